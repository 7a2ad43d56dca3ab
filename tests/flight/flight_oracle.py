"""What a flight's messages say against it, worked out from the messages and the mission alone.

1. The flight ends with something unfinished that could still finish.
2. The operator sends again, or gives up, what it knows to be done, or sends more often than it may.
3. The outcome is not what the operator knows.

Nothing of the flown code is asked: what the robot does is read from its events and stages, what the operator knows from
the acknowledgements and frames that had arrived.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from waypointctl.flight.outcome import FlightResult
from waypointctl.log.messages import (
    FINAL_STAGES,
    Ack,
    Action,
    Clock,
    Command,
    CommandStage,
    Event,
    EventKind,
    LinkRecord,
    Message,
    Mode,
    Stage,
    Telemetry,
)
from waypointctl.mission.link import Bursts, LinkDirection
from waypointctl.mission.mission import Mission

S = 1_000_000_000
ENDED = "flight ended"

# What the robot is about after each of its events; events that are not here change nothing.
ABOUT = {
    EventKind.LEG_STARTED: "walks",
    EventKind.RETURN_STARTED: "walks",
    EventKind.HOLD_STARTED: "holds",
    EventKind.OBSERVATION_STARTED: "holds",
    EventKind.RELEASE_AWAITED: "waits",
    EventKind.NAVIGATION_PAUSED: "paused",
    EventKind.SAFE_HOLD_STARTED: "secured",
    EventKind.PLAN_COMPLETED: "stands",
    EventKind.PLAN_FAILED: "stands",
    EventKind.RETURN_FAILED: "stands",
    EventKind.HOME_REACHED: "stands",
    EventKind.FALL: "fallen",
    EventKind.TELEOPERATION_STARTED: "steered",
}


@dataclass
class Told:
    """A flight as its messages tell it.

    Attributes:
        about: what the robot is about, and why it stands.
        source: what drove the motors in the last control step, which began at `acted_ns`.
        stages: of each command, the last on board with its reason, before the flight's end closes it.
        sent: of each command, when each sending was handed over [ns].
        lost: of each command, how many sendings were lost.
        arrived: of each command, how many sendings have arrived.
        done: of each command, when the operator first knew of its end [ns].
        heard: of each command, when the operator first knew of anything [ns].
        changed_ns: when something last changed on board.
        frame: the newest that has arrived.
    """

    about: str = "stands"
    cause: str = ""
    link_lost: bool = False
    source: str = ""
    acted_ns: int = -1
    stages: dict[int, tuple[Stage, str]] = field(default_factory=dict)
    kept: dict[int, int] = field(default_factory=dict)
    closed: list[int] = field(default_factory=list)
    sent: dict[int, list[int]] = field(default_factory=dict)
    lost: dict[int, int] = field(default_factory=dict)
    arrived: dict[int, int] = field(default_factory=dict)
    done: dict[int, int] = field(default_factory=dict)
    heard: dict[int, int] = field(default_factory=dict)
    targets: dict[int, frozenset[int]] = field(default_factory=dict)
    changed_ns: int = -1
    frame: Telemetry | None = None
    told_fall: bool = False
    seen: set[int] = field(default_factory=set)

    def take(self, message: Message) -> None:
        match message:
            case Action():
                self.source, self.acted_ns = message.source, message.time_ns
            case Command():
                self.arrived[message.id] = self.arrived.get(message.id, 0) + 1
                self.kept[message.id] = message.not_before_ns
                self.targets[message.id] = frozenset(waypoint.index for waypoint in message.waypoints)
            case CommandStage(clock=Clock.ROBOT):
                self._advance(message)
            case CommandStage(stage=Stage.QUEUED):
                self.sent.setdefault(message.command_id, []).append(message.time_ns)
            case LinkRecord(direction="up", message="command", arrives_ns=()):
                self.lost[message.number] = self.lost.get(message.number, 0) + 1
            case Ack():
                self._know(message.command_id, message.stage, message.received_ns)
                self.told_fall = self.told_fall or message.reason == "fall"
            case Telemetry():
                self._hear(message)
            case Event():
                self._note(message)

    def _advance(self, it: CommandStage) -> None:
        if it.stage is Stage.CANCELLED and it.reason == ENDED:
            self.closed.append(it.command_id)
            return
        self.stages[it.command_id] = (it.stage, it.reason)
        self.changed_ns = it.time_ns

    def _know(self, command_id: int, stage: Stage, now_ns: int) -> None:
        self.heard.setdefault(command_id, now_ns)
        if stage in FINAL_STAGES:
            self.done.setdefault(command_id, now_ns)

    def _hear(self, frame: Telemetry) -> None:
        if self.frame is None or frame.frame >= self.frame.frame:
            self.frame = frame
        self.told_fall = self.told_fall or frame.mode is Mode.FALLEN
        for it in frame.commands:
            self._know(it.command_id, it.stage, frame.received_ns)

    def _note(self, event: Event) -> None:
        if event.clock is Clock.OPERATOR and event.kind is EventKind.WAYPOINT_REACHED:
            self.seen.add(event.waypoint)
        if event.clock is not Clock.ROBOT:
            return
        if event.kind in (EventKind.LINK_LOST, EventKind.LINK_RESTORED):
            self.link_lost = event.kind is EventKind.LINK_LOST
        if event.kind in ABOUT:
            self.about, self.cause = ABOUT[event.kind], event.text
            self.changed_ns = max(self.changed_ns, event.time_ns)


def faults(mission: Mission, result: FlightResult, messages: Sequence[Message]) -> list[str]:
    """Return what is wrong with a flight, a line each; nothing if all is right."""
    told = Told()
    for message in messages:
        told.take(message)
    end_ns = max([result.sim_time_ns, *(one.time_ns for one in messages if isinstance(one, Action))])
    return [
        *_unfinished(mission, result, told, end_ns),
        *_insisted(mission, told),
        *_wrong_outcome(mission, result, told),
    ]


def _unfinished(mission: Mission, result: FlightResult, told: Told, end_ns: int) -> Iterator[str]:
    limit_s = mission.expect.max_time_s
    if limit_s is not None and end_ns > limit_s * S:
        return  # its time is up
    down_lives = _lives(mission.link.down, end_ns)
    if told.about == "fallen":
        if down_lives and not told.told_fall:
            yield "the operator could still hear of the fall"
        return
    beats = mission.operator.heartbeat_s is not None and _lives(mission.link.up, end_ns)
    yield from _under_way(told, beats=beats)
    yield from _to_come(mission, told, end_ns, beats=beats)
    knows = told.frame is not None and told.frame.issued_ns >= told.changed_ns
    if down_lives and not knows:
        yield f"the operator could still hear of what changed at {told.changed_ns / S:.2f} s"


def _under_way(told: Told, *, beats: bool) -> Iterator[str]:
    if told.source in ("policy", "ground") and told.acted_ns >= told.changed_ns:
        yield f"the robot has its motors driven by the {told.source} at the end"
    if told.about == "holds" and told.closed:
        yield f"a hold or an observation is under way at the end: {told.cause}"
    if told.about == "secured" and "link lost" in told.cause and told.closed and beats:
        yield "the robot would go on as soon as it hears a sign of life, and they are still sent"


def _to_come(mission: Mission, told: Told, end_ns: int, *, beats: bool) -> Iterator[str]:
    for command_id in told.closed:
        stage, _ = told.stages[command_id]
        waits = stage is Stage.ACCEPTED and told.kept[command_id] > end_ns
        if waits and (beats or not told.link_lost):
            yield f"command {command_id} is kept for later, and would still be started"
    for command_id, sent in told.sent.items():
        if len(sent) > told.lost.get(command_id, 0) + told.arrived.get(command_id, 0):
            yield f"command {command_id} is still under way to the robot"
    unsent = sum(round(each.at_s * S) > end_ns for each in mission.schedule)
    if unsent and not told.told_fall:
        yield f"{unsent} scheduled commands have not been sent"


def _insisted(mission: Mission, told: Told) -> Iterator[str]:
    for command_id, sent in told.sent.items():
        if len(sent) > mission.commands.retries + 1:
            yield f"command {command_id} was sent {len(sent)} times"
        known_ns = told.done.get(command_id)
        again = [time_ns for time_ns in sent[1:] if known_ns is not None and time_ns > known_ns]
        if again:
            yield f"command {command_id} was sent again at {again[0] / S:.2f} s, and its end was known"


def _wrong_outcome(mission: Mission, result: FlightResult, told: Told) -> Iterator[str]:
    known = set(told.frame.reached) if told.frame is not None else set()
    if mission.autonomy == "joint":
        known = told.seen
    if len(known) != result.waypoints_reached:
        yield f"{len(known)} waypoints are known to be reached, and {result.waypoints_reached} are told"
    wanted = mission.num_legs if mission.expect.reached == "all" else mission.expect.reached
    if result.outcome == "success" and (len(known) < wanted or told.told_fall):
        yield f"a success with {len(known)} of {wanted} waypoints"
    for command_id in told.heard:
        if f"no acknowledgement of command {command_id} " in result.reason:
            yield f"given up for want of an acknowledgement of command {command_id}, of which something was heard"
    for command_id in told.done:
        if f"the end of command {command_id} " in result.reason:
            yield f"given up for the end of command {command_id}, which was known"
    gave_up = "no acknowledgement" in result.reason or "no final stage received" in result.reason
    if gave_up and len(known) >= wanted and mission.expect.max_time_s is None:
        yield "given up, and all that was expected is known to be reached"


def _lives(way: LinkDirection, now_ns: int) -> bool:
    """Tell whether a message that is sent now or later may arrive."""
    if way.windows is not None and way.windows_period_s is None and way.windows[-1].to_s * S <= now_ns:
        return False
    loss = way.loss
    if isinstance(loss, Bursts):
        # One that stays bad for ever may be bad already: nobody who reads the messages can tell.
        return loss.r > 0 or loss.one_minus_h < 1
    return loss < 1
