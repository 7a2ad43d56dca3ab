"""Messages to protobuf bytes: the rare ones, those of every control step are in steps.py. The inverse is decode.py."""

from __future__ import annotations

from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage

from waypointctl.log.foxglove.geometry import timestamp
from waypointctl.log.messages import (
    Ack,
    Checkpoint,
    Command,
    CommandStage,
    ConsoleInput,
    Event,
    GroundControl,
    LinkRecord,
    Picture,
    PlannedWaypoint,
    Telemetry,
)
from waypointctl.log.proto import messages_pb2 as pb
from waypointctl.units import seconds


def _waypoint(waypoint: PlannedWaypoint) -> pb.PlannedWaypoint:
    return pb.PlannedWaypoint(
        index=waypoint.index,
        name=waypoint.name,
        x_m=waypoint.x_m,
        y_m=waypoint.y_m,
        acceptance=waypoint.acceptance,
        tolerance_m=waypoint.tolerance_m,
        timeout_ns=waypoint.timeout_ns,
        hold_ns=waypoint.hold_ns,
        task=waypoint.task,
    )


def command(message: Command) -> bytes:
    """Encode a Command."""
    return pb.Command(
        id=message.id,
        kind=message.kind,
        waypoints=[_waypoint(waypoint) for waypoint in message.waypoints],
        on_failure=message.on_failure,
        issued_ns=message.issued_ns,
        received_ns=message.received_ns,
        delay_s=seconds(message.received_ns - message.issued_ns),
        attempt=message.attempt,
        released=message.released,
        target_id=message.target_id,
        value=message.value,
        not_before_ns=message.not_before_ns,
        expires_ns=message.expires_ns,
    ).SerializeToString()


def command_stage(message: CommandStage) -> bytes:
    """Encode a CommandStage."""
    return pb.CommandStage(
        time_ns=message.time_ns,
        command_id=message.command_id,
        stage=message.stage,
        reason=message.reason,
        clock=message.clock,
        attempt=message.attempt,
    ).SerializeToString()


def ack(message: Ack) -> bytes:
    """Encode an Ack."""
    return pb.Ack(
        command_id=message.command_id,
        stage=message.stage,
        reason=message.reason,
        issued_ns=message.issued_ns,
        received_ns=message.received_ns,
        delay_s=seconds(message.received_ns - message.issued_ns),
    ).SerializeToString()


def telemetry(message: Telemetry) -> bytes:
    """Encode a Telemetry frame."""
    return pb.Telemetry(
        frame=message.frame,
        mode=message.mode,
        x_m=message.x_m,
        y_m=message.y_m,
        z_m=message.z_m,
        heading_rad=message.heading_rad,
        speed_mps=message.speed_mps,
        target=message.target,
        reached=message.reached,
        issued_ns=message.issued_ns,
        received_ns=message.received_ns,
        delay_s=seconds(message.received_ns - message.issued_ns),
        commands=[
            pb.Telemetry.CommandStatus(command_id=each.command_id, stage=each.stage, reason=each.reason)
            for each in message.commands
        ],
        cause=message.cause,
    ).SerializeToString()


def ground_control(message: GroundControl) -> bytes:
    """Encode a GroundControl."""
    return pb.GroundControl(
        time_ns=message.time_ns,
        step=message.step,
        issued_ns=message.issued_ns,
        observation=message.observation.tolist(),
        commanded=message.commanded.tolist(),
    ).SerializeToString()


def link_record(message: LinkRecord) -> bytes:
    """Encode a LinkRecord."""
    return pb.LinkRecord(
        time_ns=message.time_ns,
        direction=message.direction,
        message=message.message,
        number=message.number,
        size_bytes=message.size_bytes,
        departs_ns=message.departs_ns,
        arrives_ns=message.arrives_ns,
        outcome=message.outcome,
        delay_s=seconds(message.arrives_ns[0] - message.time_ns) if message.arrives_ns else 0.0,
    ).SerializeToString()


def console_input(message: ConsoleInput) -> bytes:
    """Encode a ConsoleInput."""
    return pb.ConsoleInput(time_ns=message.time_ns, text=message.text).SerializeToString()


def event(message: Event) -> bytes:
    """Encode an Event."""
    return pb.Event(
        time_ns=message.time_ns,
        kind=message.kind,
        clock=message.clock,
        severity=message.severity,
        text=message.text,
        waypoint=message.waypoint,
        command_id=message.command_id,
    ).SerializeToString()


def picture(message: Picture) -> bytes:
    """Encode a Picture."""
    data: bytes = CompressedImage(
        timestamp=timestamp(message.time_ns), frame_id=message.frame_id, data=message.data, format=message.format
    ).SerializeToString()
    return data


def checkpoint(message: Checkpoint) -> bytes:
    """Encode a Checkpoint."""
    return pb.Checkpoint(
        time_ns=message.time_ns,
        step=message.step,
        integration=message.integration.tolist(),
        executive=message.executive,
        link=message.link,
        policy_state=message.policy_state,
    ).SerializeToString()
