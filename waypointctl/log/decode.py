"""Protobuf bytes to messages, equal to those that encode.py was given, floats bit for bit.

A word outside its enumeration, or an unknown source of an action, raises ValueError; bytes that are not such a message
raise google.protobuf.message.DecodeError. The reader adds their place.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage

from waypointctl.log.messages import (
    Ack,
    Action,
    Checkpoint,
    Clock,
    Command,
    CommandKind,
    CommandStage,
    CommandStatus,
    ConsoleInput,
    DeliveryOutcome,
    Event,
    EventKind,
    FloatArray,
    GroundControl,
    LinkRecord,
    Mode,
    Observation,
    Picture,
    PlannedWaypoint,
    Reward,
    Severity,
    Stage,
    State,
    Telemetry,
)
from waypointctl.log.proto import messages_pb2 as pb
from waypointctl.units import NS_PER_S

_SOURCES: Final = ("policy", "ground", "stance", "off")  # who had the motors


def _array(values: Sequence[float]) -> FloatArray:
    # A slice is a plain list, which numpy reads twice as fast as protobuf's container.
    return np.array(values[:], dtype=np.float64)


def state(data: bytes) -> State:
    """Decode a State."""
    it = pb.State.FromString(data)
    return State(it.time_ns, it.step, _array(it.qpos), _array(it.qvel), _array(it.qacc_warmstart))


def observation(data: bytes) -> Observation:
    """Decode an Observation."""
    it = pb.Observation.FromString(data)
    return Observation(it.time_ns, it.step, _array(it.values))


def action(data: bytes) -> Action:
    """Decode an Action."""
    it = pb.Action.FromString(data)
    if it.source not in _SOURCES:
        raise ValueError(f"{it.source!r} is not a source of an action; allowed: {', '.join(_SOURCES)}")
    return Action(it.time_ns, it.step, it.source, _array(it.commanded), _array(it.applied))


def reward(data: bytes) -> Reward:
    """Decode a Reward."""
    it = pb.Reward.FromString(data)
    return Reward(it.time_ns, it.step, tuple([(term.name, term.value) for term in it.terms]), it.total)


def _waypoint(it: pb.PlannedWaypoint) -> PlannedWaypoint:
    return PlannedWaypoint(
        it.index, it.name, it.x_m, it.y_m, it.acceptance, it.tolerance_m, it.timeout_ns, it.hold_ns, it.task
    )


def command(data: bytes) -> Command:
    """Decode a Command."""
    it = pb.Command.FromString(data)
    waypoints = tuple(_waypoint(waypoint) for waypoint in it.waypoints)
    return Command(
        id=it.id,
        kind=CommandKind(it.kind),
        waypoints=waypoints,
        on_failure=it.on_failure,
        issued_ns=it.issued_ns,
        received_ns=it.received_ns,
        attempt=it.attempt,
        released=it.released,
        target_id=it.target_id,
        value=it.value,
        not_before_ns=it.not_before_ns,
        expires_ns=it.expires_ns,
    )


def command_stage(data: bytes) -> CommandStage:
    """Decode a CommandStage."""
    it = pb.CommandStage.FromString(data)
    return CommandStage(it.time_ns, it.command_id, Stage(it.stage), it.reason, Clock(it.clock), it.attempt)


def ack(data: bytes) -> Ack:
    """Decode an Ack."""
    it = pb.Ack.FromString(data)
    return Ack(it.command_id, Stage(it.stage), it.reason, it.issued_ns, it.received_ns)


def telemetry(data: bytes) -> Telemetry:
    """Decode a Telemetry frame."""
    it = pb.Telemetry.FromString(data)
    return Telemetry(
        frame=it.frame,
        mode=Mode(it.mode),
        x_m=it.x_m,
        y_m=it.y_m,
        z_m=it.z_m,
        heading_rad=it.heading_rad,
        speed_mps=it.speed_mps,
        target=it.target,
        reached=tuple(it.reached),
        issued_ns=it.issued_ns,
        received_ns=it.received_ns,
        commands=tuple(CommandStatus(each.command_id, Stage(each.stage), each.reason) for each in it.commands),
        cause=it.cause,
    )


def ground_control(data: bytes) -> GroundControl:
    """Decode a GroundControl."""
    it = pb.GroundControl.FromString(data)
    return GroundControl(it.time_ns, it.step, it.issued_ns, _array(it.observation), _array(it.commanded))


def link_record(data: bytes) -> LinkRecord:
    """Decode a LinkRecord."""
    it = pb.LinkRecord.FromString(data)
    return LinkRecord(
        time_ns=it.time_ns,
        direction=it.direction,
        message=it.message,
        number=it.number,
        size_bytes=it.size_bytes,
        departs_ns=it.departs_ns,
        arrives_ns=tuple(it.arrives_ns),
        outcome=DeliveryOutcome(it.outcome),
    )


def console_input(data: bytes) -> ConsoleInput:
    """Decode a ConsoleInput."""
    it = pb.ConsoleInput.FromString(data)
    return ConsoleInput(it.time_ns, it.text)


def event(data: bytes) -> Event:
    """Decode an Event."""
    it = pb.Event.FromString(data)
    return Event(
        it.time_ns, EventKind(it.kind), Clock(it.clock), Severity(it.severity), it.text, it.waypoint, it.command_id
    )


def picture(data: bytes) -> Picture:
    """Decode a Picture."""
    it = CompressedImage.FromString(data)
    time_ns = it.timestamp.seconds * NS_PER_S + it.timestamp.nanos
    return Picture(time_ns, it.frame_id, it.format, it.data)


def checkpoint(data: bytes) -> Checkpoint:
    """Decode a Checkpoint."""
    it = pb.Checkpoint.FromString(data)
    return Checkpoint(it.time_ns, it.step, _array(it.integration), it.executive, it.link, it.policy_state)
