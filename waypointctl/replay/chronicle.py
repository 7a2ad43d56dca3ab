"""A sink that gathers a flight's story while it happens, or from its log."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import islice
from typing import Final

from waypointctl.flight.executive.plan import names
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
    PlannedWaypoint,
    Reward,
    Severity,
    Stage,
    State,
    Telemetry,
)
from waypointctl.log.setting import MissionSetting
from waypointctl.replay.effort import EffortTally
from waypointctl.replay.growing_records import GrowingCommand, GrowingWaypoint
from waypointctl.replay.link_story import LinkTally
from waypointctl.replay.return_home import ReturnHome, ReturnsFold
from waypointctl.replay.story import UNFINISHED, CommandStory, Fate, Story, WaypointStory
from waypointctl.replay.track import GrowingTrack, Track, is_on_map

_FATES: Final = {
    EventKind.WAYPOINT_REACHED: Fate.REACHED,
    EventKind.WAYPOINT_TIMEOUT: Fate.TIMED_OUT,
    EventKind.WAYPOINT_SKIPPED: Fate.SKIPPED,
}
# What the robot does instead of walking on to a waypoint.
_ENDS_A_LEG: Final = frozenset(
    {
        EventKind.FALL,
        EventKind.LEG_STARTED,
        EventKind.PLAN_COMPLETED,
        EventKind.PLAN_FAILED,
        EventKind.RETURN_STARTED,
        EventKind.TELEOPERATION_STARTED,
    }
)
_NO_SETTING: Final = MissionSetting()


def tell(
    messages: Iterable[Message], waypoints: Iterable[PlannedWaypoint] = (), setting: MissionSetting = _NO_SETTING
) -> Story:
    """Return the story of a flight.

    Args:
        messages: all of them, in order.
        waypoints: the mission's; without them, those that were commanded.
        setting: what else the mission has fixed beforehand.
    """
    chronicle = Chronicle(waypoints, setting)
    for message in messages:
        chronicle(message)
    return chronicle.story()


class Chronicle:
    """Takes each message of a flight; ask it for the story at any time.

    Attributes:
        now_ns: the latest time that a message has shown, on either clock.
        state: the newest true state of the robot that is on the map.
        telemetry: of the frames that have arrived at the operator, the one that was sampled last.
        events: all so far.
        setting: what the mission has fixed beforehand.
        link: what the link has done so far.
    """

    def __init__(self, waypoints: Iterable[PlannedWaypoint] = (), setting: MissionSetting = _NO_SETTING) -> None:
        """Begin with the waypoints of the mission, where they are known beforehand, and what else it has fixed."""
        self.setting, self.link = setting, LinkTally()
        self.now_ns = 0
        self.state: State | None = None
        self.telemetry: Telemetry | None = None
        self.events: list[Event] = []
        self._waypoints = {waypoint.index: GrowingWaypoint(waypoint) for waypoint in waypoints}
        self._leg: GrowingWaypoint | None = None  # the one that was begun last
        self._commands: dict[int, GrowingCommand] = {}
        self._places: dict[tuple[float, float], PlannedWaypoint] = {}  # commanded, and none of the waypoints
        self._truth, self._belief = GrowingTrack(), GrowingTrack()
        self._effort, self._returns = EffortTally(), ReturnsFold()
        self._learned = 0  # how many of the waypoints in telemetry's `reached`, which only grows, have been taken
        self._acknowledged = -1  # the newest command of which anything has been heard
        self._states_off_map = self._frames_off_map = 0
        self._reward: dict[str, float] = {}
        self._reward_total = 0.0
        self._steps = 0

    def __call__(self, message: Message) -> None:
        """Take one message."""
        match message:
            case State():
                self._move(message)
            case Action():
                self._effort.source = message.source
                self._steps += 1
            case Reward():
                self._pay(message)
            case Telemetry():
                self._hear(message)
            case Ack():
                self.now_ns = max(self.now_ns, message.received_ns)
                self._command(message.command_id).acks.append(message)
                self._acknowledged = max(self._acknowledged, message.command_id)
                self._returns.hear(message)
            case Command():
                self._receive(message)
            case CommandStage():
                self._advance(message)
            case LinkRecord():
                self.link.add(message)
            case Event():
                self._note(message)

    @property
    def commands(self) -> tuple[CommandStory, ...]:
        """The commands so far, by id."""
        return tuple(command.story(id_) for id_, command in sorted(self._commands.items()))

    def newest_commands(self, most: int) -> tuple[CommandStory, ...]:
        """Return the last `most` commands that were issued, by id."""
        newest = sorted(islice(reversed(self._commands), most))
        return tuple(self._commands[command_id].story(command_id) for command_id in newest)

    @property
    def round_trip_ns(self) -> int | None:
        """The round trip of the newest command that was acknowledged [ns]; None without one."""
        command = self._commands.get(self._acknowledged)
        return None if command is None else command.story(self._acknowledged).round_trip_ns

    @property
    def waypoints(self) -> tuple[WaypointStory, ...]:
        """The waypoints of the mission, and what has become of them so far."""
        return tuple(waypoint.story() for _, waypoint in sorted(self._waypoints.items()))

    @property
    def returns(self) -> tuple[ReturnHome, ...]:
        """The ways home so far."""
        return self._returns.returns

    def truth(self, most: int) -> Track:
        """Return where the robot has been so far, in about `most` rows."""
        return self._truth.track(most)

    def belief(self, most: int) -> Track:
        """Return where telemetry has seen the robot so far, in about `most` rows."""
        return self._belief.track(most)

    def story(self) -> Story:
        """Return the story so far."""
        outcome, reason, ended_ns = self._ending()
        return Story(
            outcome=outcome,
            reason=reason,
            ended_ns=ended_ns,
            steps=self._steps,
            waypoints=self.waypoints,
            places=tuple(self._places.values()),
            commands=self.commands,
            events=tuple(self.events),
            reward=tuple(self._reward.items()),
            reward_total=self._reward_total,
            effort=self._effort.effort(),
            moving=self._effort.moving,
            resting=self._effort.resting(self.now_ns),
            returns=self.returns,
            truth=self._truth.track(),
            belief=self._belief.track(),
            states_off_map=self._states_off_map,
            frames_off_map=self._frames_off_map,
            link=self.link.story(self.now_ns),
            setting=self.setting,
        )

    def _ending(self) -> tuple[str, str, int]:
        for event in reversed(self.events):
            if event.kind is EventKind.MISSION_ENDED:
                outcome, _, reason = event.text.partition(": ")
                return outcome, reason, event.time_ns
        return UNFINISHED, "the log has no end", self.now_ns

    def _move(self, state: State) -> None:
        self.now_ns = max(self.now_ns, state.time_ns)
        place = (*state.qpos[:2].tolist(), *state.qvel[:2].tolist())
        if len(place) < 4 or not is_on_map(*place):
            self._states_off_map += 1
            return
        x_m, y_m, *velocity_mps = place
        if self.state is not None:
            self._effort.step(self.state, state)
        self.state = state
        self._truth.add(state.time_ns, state.time_ns, x_m, y_m, math.hypot(*velocity_mps))

    def _pay(self, reward: Reward) -> None:
        for name, value in reward.terms:
            self._reward[name] = self._reward.get(name, 0.0) + value
        self._reward_total += reward.total

    def _hear(self, frame: Telemetry) -> None:
        self.now_ns = max(self.now_ns, frame.received_ns)
        if self.telemetry is None or frame.issued_ns >= self.telemetry.issued_ns:
            self.telemetry = frame
        self._returns.hear(frame)
        if is_on_map(frame.x_m, frame.y_m, frame.speed_mps):
            self._belief.add(frame.issued_ns, frame.received_ns, frame.x_m, frame.y_m, frame.speed_mps)
        else:
            self._frames_off_map += 1
        for it in frame.commands:
            command = self._command(it.command_id)
            if it.stage in FINAL_STAGES and command.told is None:
                command.told = it.stage, frame.received_ns
        for index in frame.reached[self._learned :]:
            waypoint = self._waypoints.get(index)
            if waypoint is not None and waypoint.learned_ns is None:
                waypoint.learned_ns = frame.received_ns
        self._learned = max(self._learned, len(frame.reached))

    def _receive(self, command: Command) -> None:
        entry = self._command(command.id)
        entry.arrivals.append((command.issued_ns, command.received_ns))
        if entry.received_ns is None:  # what arrives once more is only acknowledged once more
            entry.received_ns, entry.carried_ns = command.received_ns, command.received_ns - command.issued_ns
            if not entry.attempts:
                entry.issued_ns = command.issued_ns
            entry.kind = command.kind
            entry.what = f"{command.kind} {names(command.waypoints)}".rstrip()
        for waypoint in command.waypoints:
            if waypoint.index < 0:
                self._places.setdefault((waypoint.x_m, waypoint.y_m), waypoint)
            else:
                self._waypoints.setdefault(waypoint.index, GrowingWaypoint(waypoint))

    def _advance(self, it: CommandStage) -> None:
        self.now_ns = max(self.now_ns, it.time_ns)
        entry = self._command(it.command_id)
        entry.attempts = max(entry.attempts, it.attempt)
        if it.stage is Stage.QUEUED and it.attempt == 1:
            entry.issued_ns = it.time_ns
        elif it.stage is Stage.LOST:
            entry.losses += 1
        self._returns.advance(it, entry.kind)
        if it.clock is Clock.ROBOT and entry.onboard not in FINAL_STAGES:
            entry.onboard = it.stage
            entry.ended_ns = it.time_ns if it.stage in FINAL_STAGES else None

    def _note(self, event: Event) -> None:
        self.now_ns = max(self.now_ns, event.time_ns)
        self.events.append(event)
        for fold in (self._returns, self.link, self._effort):
            fold.note(event)
        if event.kind is EventKind.COMMAND_SENT and event.severity is Severity.INFO:
            self._command(event.command_id).what = event.text.partition(": ")[2]
        if event.kind in _ENDS_A_LEG and self._leg is not None and self._leg.ended_ns is None:
            self._leg.ended_ns = event.time_ns
        waypoint = self._waypoints.get(event.waypoint)
        if waypoint is not None:
            self._visit(waypoint, event)

    def _visit(self, waypoint: GrowingWaypoint, event: Event) -> None:
        waypoint.fate = _FATES.get(event.kind, waypoint.fate)
        if event.kind is EventKind.LEG_STARTED:
            waypoint.started_ns = event.time_ns
            waypoint.ended_ns = None
            self._leg = waypoint
        elif event.kind is EventKind.WAYPOINT_REACHED:
            waypoint.reached_ns = waypoint.ended_ns = event.time_ns
        elif event.kind is EventKind.WAYPOINT_TIMEOUT:
            waypoint.ended_ns = event.time_ns

    def _command(self, command_id: int) -> GrowingCommand:
        return self._commands.setdefault(command_id, GrowingCommand())
