"""What happens in a flight, as frozen records: the sink takes them, the reader gives them back.

All times are simulation time in [ns], 0 at mission start. A record that travels the link has two: when it was
issued and when it arrived; the log keeps them as publish_time and log_time. Control step k begins at
State(step=k), which Observation and Action k follow; Reward k closes it, one control period later.
Arrays are float64 and belong to the record: whoever makes one hands over a copy.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]


class CommandKind(StrEnum):
    """The commands of an operator."""

    UPLOAD_PLAN = "upload_plan"  # a plan in place of the one there is
    APPEND_PLAN = "append_plan"  # waypoints after those of the plan there is
    RELEASE = "release"  # how far the robot may drive
    GO_TO = "go_to"  # a place, in place of the plan
    HOLD = "hold"  # stand where it is
    RESUME = "resume"  # continue after a hold
    SKIP = "skip"  # leave the current waypoint
    CANCEL = "cancel"  # take an earlier command back
    ABORT = "abort"  # drop everything and stand
    SET_TOLERANCE = "set_tolerance"  # of the waypoints to come [m]
    SET_TIMEOUT = "set_timeout"  # of the waypoints to come [s]
    RETURN_HOME = "return_home"  # drive to the home position


class Stage(StrEnum):
    """Where a command stands. The robot reports the stages from RECEIVED on in acknowledgements."""

    QUEUED = "queued"  # handed to the link by the operator
    SENT = "sent"  # its first bit has left
    LOST = "lost"  # it will not arrive; neither end is notified
    RECEIVED = "received"
    REJECTED = "rejected"  # final: it cannot be executed
    ACCEPTED = "accepted"
    STARTED = "started"
    COMPLETED = "completed"  # final
    FAILED = "failed"  # final: it was tried
    CANCELLED = "cancelled"  # final: taken back
    SUPERSEDED = "superseded"  # final: another command took its place
    EXPIRED = "expired"  # final: its time was over before it could start or end
    SKIPPED = "skipped"  # final: it came too late to be of use
    UNKNOWN = "unknown"  # the operator's alone: its acknowledgement is late


FINAL_STAGES: Final = frozenset(
    {Stage.REJECTED, Stage.COMPLETED, Stage.FAILED, Stage.CANCELLED, Stage.SUPERSEDED, Stage.EXPIRED, Stage.SKIPPED}
)


class Mode(StrEnum):
    """What the executive on board is doing."""

    IDLE = "idle"  # standing, no plan yet
    NAVIGATING = "navigating"  # the policy drives the motors
    HOLDING = "holding"  # standing at a waypoint for its hold time
    OBSERVING = "observing"  # standing at a waypoint and taking a picture
    WAITING = "waiting"  # standing before a waypoint that is not released yet
    PAUSED = "paused"  # standing by a hold command
    SAFE = "safe"  # standing by a rule: link loss, geofence, no progress
    RETURNING = "returning"  # the policy drives the motors, on the way home
    TELEOPERATED = "teleoperated"  # the operator drives the motors
    DONE = "done"  # standing, the plan is finished
    FAILED = "failed"  # standing, the plan was given up
    FALLEN = "fallen"  # motors off


class Clock(StrEnum):
    """Whose clock an event's time is on."""

    ROBOT = "robot"
    OPERATOR = "operator"
    LINK = "link"  # lost messages: neither end is notified


class Severity(StrEnum):
    """How much an event matters; the names are foxglove.Log's levels."""

    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


class EventKind(StrEnum):
    """What can happen."""

    MISSION_STARTED = "mission_started"  # operator
    CONSOLE_OPENED = "console_opened"  # operator: a person can send commands
    CONSOLE_CLOSED = "console_closed"  # operator: nothing more will be typed
    COMMAND_SENT = "command_sent"  # operator
    COMMAND_KNOWN = "command_known"  # operator: telemetry reported its end, and no acknowledgement arrived
    COMMAND_RECEIVED = "command_received"  # robot
    LEG_STARTED = "leg_started"  # robot
    WAYPOINT_REACHED = "waypoint_reached"  # robot
    HOLD_STARTED = "hold_started"  # robot
    HOLD_COMPLETED = "hold_completed"  # robot
    WAYPOINT_TIMEOUT = "waypoint_timeout"  # robot
    WAYPOINT_SKIPPED = "waypoint_skipped"  # robot
    WAYPOINT_STUCK = "waypoint_stuck"  # robot: it gets no closer
    LEG_RETRIED = "leg_retried"  # robot: the leg's time begins again
    RELEASE_AWAITED = "release_awaited"  # robot: the next waypoint is not released
    OBSERVATION_STARTED = "observation_started"  # robot
    OBSERVATION_TAKEN = "observation_taken"  # robot; the State of the same time follows: a picture is made from it
    NAVIGATION_PAUSED = "navigation_paused"  # robot
    NAVIGATION_RESUMED = "navigation_resumed"  # robot
    SAFE_HOLD_STARTED = "safe_hold_started"  # robot: it stands by a rule on board
    RETURN_STARTED = "return_started"  # robot
    HOME_REACHED = "home_reached"  # robot
    GEOFENCE_BREACHED = "geofence_breached"  # robot
    LINK_LOST = "link_lost"  # robot: nothing has arrived for too long
    LINK_RESTORED = "link_restored"  # robot
    TELEOPERATION_STARTED = "teleoperation_started"  # robot: the operator drives the motors
    REST_STARTED = "rest_started"  # robot: it stands so still that physics sleeps until something happens
    REST_ENDED = "rest_ended"  # robot
    FALL = "fall"  # robot
    PLAN_COMPLETED = "plan_completed"  # robot
    PLAN_FAILED = "plan_failed"  # robot
    RETURN_FAILED = "return_failed"  # robot: the way home is given up
    MISSION_ENDED = "mission_ended"  # operator: the last record of a flight that was not killed


@dataclass(frozen=True, slots=True)
class State:
    """The robot's true physics state at the beginning of a control step (and after the last one)."""

    time_ns: int
    step: int
    qpos: FloatArray  # (nq,) [m, quaternion w x y z, rad]
    qvel: FloatArray  # (nv,) [m/s in the world frame, rad/s in the body frame, rad/s]
    qacc_warmstart: FloatArray  # (nv,) the solver's warm start, without which no replay is exact


@dataclass(frozen=True, slots=True)
class Observation:
    """What the policy saw; there is none for a step in which the policy did not have the motors."""

    time_ns: int
    step: int
    values: FloatArray  # (k,) in the layout named in the log's metadata


@dataclass(frozen=True, slots=True)
class Action:
    """The action of a control step: a number for each actuator; the robot's robot.yaml says what it means."""

    time_ns: int
    step: int
    source: str  # "policy", "ground" or "stance" (the robot's own standing controller) or "off" (fallen)
    commanded: FloatArray  # (nu,) as the source gave it
    applied: FloatArray  # (nu,) after clipping: what the motors did


@dataclass(frozen=True, slots=True)
class Reward:
    """The reward of the control step that ended at `time_ns`, by term, weighted."""

    time_ns: int
    step: int
    terms: tuple[tuple[str, float], ...]
    total: float


@dataclass(frozen=True, slots=True)
class PlannedWaypoint:
    """One waypoint as it is commanded."""

    index: int  # its place in the mission, from 0
    name: str
    x_m: float
    y_m: float
    acceptance: str  # "box" or "radius"
    tolerance_m: float  # half the box's side, or the radius
    timeout_ns: int  # from the start of the leg
    hold_ns: int
    task: str = ""  # what to do there after the hold: nothing, or "observe"


TELEOPERATION: Final = -2  # in place of a command's id


@dataclass(frozen=True, slots=True)
class Command:
    """A telecommand that has arrived at the robot."""

    id: int
    kind: CommandKind
    waypoints: tuple[PlannedWaypoint, ...]
    on_failure: str  # "abort", "skip", "hold" or "return_home"; empty for the robot's own rule
    issued_ns: int  # by the operator
    received_ns: int  # by the robot
    attempt: int = 1  # which sending of this id it is
    released: int = -1  # how many waypoints of the plan the robot may drive to; -1 for all
    target_id: int = -1  # the command that a CANCEL takes back; TELEOPERATION for a HOLD that stops that alone
    value: float = 0.0  # of SET_TOLERANCE [m], of SET_TIMEOUT [s]
    not_before_ns: int = -1  # it starts no earlier; -1 for at once
    expires_ns: int = -1  # after this it is not to be started or continued; -1 for never


@dataclass(frozen=True, slots=True)
class CommandStage:
    """A stage of a command at the moment when it came to it, whoever knows of it then."""

    time_ns: int
    command_id: int
    stage: Stage
    reason: str  # empty, or why it was lost, rejected, failed, ...
    clock: Clock
    attempt: int  # which sending of this id it is about


@dataclass(frozen=True, slots=True)
class Ack:
    """A stage of a command, reported by the robot and arrived at the operator."""

    command_id: int
    stage: Stage
    reason: str  # empty, or why it was rejected or failed
    issued_ns: int  # by the robot
    received_ns: int  # by the operator


@dataclass(frozen=True, slots=True)
class CommandStatus:
    """What a command had come to on board when a frame of telemetry was sampled."""

    command_id: int
    stage: Stage
    reason: str = ""  # empty, or why it was rejected or failed


@dataclass(frozen=True, slots=True)
class Telemetry:
    """A frame of telemetry that has arrived at the operator: all that the operator knows."""

    frame: int
    mode: Mode
    x_m: float
    y_m: float
    z_m: float
    heading_rad: float
    speed_mps: float
    target: int  # index of the waypoint the robot drives to or holds at; -1 for none
    reached: tuple[int, ...]  # indices of the waypoints reached so far
    issued_ns: int  # sampled by the robot
    received_ns: int  # by the operator
    commands: tuple[CommandStatus, ...] = ()  # those that have not ended and those that ended last, three at most
    cause: str = ""  # why it stands or returns home: a rule or a command


@dataclass(frozen=True, slots=True)
class GroundControl:
    """An action that was computed on the ground, from a state that has arrived there: autonomy `joint`."""

    time_ns: int  # on the operator's clock, when it was computed and sent
    step: int  # the control step whose state it was computed from
    issued_ns: int  # when the robot was in that state
    observation: FloatArray  # (k,) in the layout named in the log's metadata
    commanded: FloatArray  # (nu,) as the policy gave it


class DeliveryOutcome(StrEnum):
    """What the link did to a message beyond delaying it."""

    QUEUED = "queued"  # it was not sent at once
    DUPLICATED = "duplicated"  # it arrives twice; it may have been queued too
    LOST = "lost"  # on the way
    QUEUE_FULL = "queue_full"  # the queue was full
    NO_CONTACT = "no_contact"  # no remaining contact has room for it


NOT_DELIVERED: Final = frozenset({DeliveryOutcome.LOST, DeliveryOutcome.QUEUE_FULL, DeliveryOutcome.NO_CONTACT})


@dataclass(frozen=True, slots=True)
class LinkRecord:
    """A message that the link lost, duplicated or queued: neither end learns of it as such."""

    time_ns: int  # when it was handed to the link
    direction: str  # "up" or "down"
    message: str  # "command", "ack", "telemetry", ...
    number: int  # the command's id, the frame's number, or the control step
    size_bytes: int  # on the wire
    departs_ns: int  # when its first bit leaves; -1 if it does not
    arrives_ns: tuple[int, ...]  # once, twice, or not at all
    outcome: DeliveryOutcome


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened, on the robot's clock or on the operator's."""

    time_ns: int
    kind: EventKind
    clock: Clock
    severity: Severity
    text: str
    waypoint: int = -1  # its index in the mission, where the event is about one
    command_id: int = -1  # where the event is about one


@dataclass(frozen=True, slots=True)
class ConsoleInput:
    """A line typed at the operator's console that was carried out: a command was sent, or the console was closed."""

    time_ns: int  # on the operator's clock
    text: str


@dataclass(frozen=True, slots=True)
class Picture:
    """What the robot's camera saw when an observation was taken; foxglove.CompressedImage in the log."""

    time_ns: int  # of the OBSERVATION_TAKEN, whose State it follows
    frame_id: str  # the camera's name
    format: str  # "png"
    data: bytes  # the file; png.py describes its text chunks


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """Everything that a replay needs to start in the middle."""

    time_ns: int
    step: int
    integration: FloatArray  # mjSTATE_INTEGRATION
    executive: str  # JSON: the executive's state
    link: str  # JSON: what is under way in the link, and its random streams
    policy_state: str = ""  # JSON: the arrays of a policy that has a state; empty for the others


Message: TypeAlias = (
    State
    | Observation
    | Action
    | Reward
    | Command
    | CommandStage
    | Ack
    | Telemetry
    | GroundControl
    | LinkRecord
    | ConsoleInput
    | Event
    | Picture
    | Checkpoint
)
