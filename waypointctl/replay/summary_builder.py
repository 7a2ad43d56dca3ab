"""A sink that makes a flight's summary of its messages, while it happens or from its log."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

from waypointctl.log.header import MissionSetting
from waypointctl.log.messages import (
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
    State,
    Telemetry,
)
from waypointctl.log.reader import LogReader
from waypointctl.replay.command_summary import CommandsBuilder, CommandSummary
from waypointctl.replay.legs import ReturnHome, ReturnsBuilder, WaypointsBuilder, WaypointSummary
from waypointctl.replay.link_summary import LinkSummaryBuilder
from waypointctl.replay.summary import UNFINISHED, FlightSummary
from waypointctl.replay.track import EffortBuilder, Track, TrackBuilder, is_on_map

_NO_SETTING: Final = MissionSetting()


def summarize(
    messages: Iterable[Message], waypoints: Iterable[PlannedWaypoint] = (), setting: MissionSetting = _NO_SETTING
) -> FlightSummary:
    """Return the summary of a flight's messages, all of them, in order.

    Without the mission's waypoints it has those that were commanded.
    """
    flight = FlightSummaryBuilder(waypoints, setting)
    for message in messages:
        flight(message)
    return flight.summary()


def summary_of_events(log: LogReader) -> FlightSummary:
    """Return the summary of a log's events alone: outcome, end, console. Quick, and in any log."""
    return summarize(log.messages(("/event",)))


class FlightSummaryBuilder:
    """Takes each message of a flight; ask it for the summary at any time.

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
        self.setting, self.link = setting, LinkSummaryBuilder()
        self.now_ns = 0
        self.state: State | None = None
        self.telemetry: Telemetry | None = None
        self.events: list[Event] = []
        self._waypoints, self._commands = WaypointsBuilder(waypoints), CommandsBuilder()
        self._truth, self._belief = TrackBuilder(), TrackBuilder()
        self._effort, self._returns = EffortBuilder(), ReturnsBuilder()
        self._states_off_map = self._frames_off_map = 0
        self._reward: dict[str, float] = {}
        self._reward_total = 0.0
        self._steps = 0

    def __call__(self, message: Message) -> None:
        """Take one message."""
        match message:
            case State():
                self._on_state(message)
            case Action():
                self._effort.source = message.source
                self._steps += 1
            case Reward():
                self._on_reward(message)
            case Telemetry():
                self._on_telemetry(message)
            case Ack():
                self._on_ack(message)
            case Command():
                self._commands.on_command(message)
                self._waypoints.on_command(message)
            case CommandStage():
                self._on_stage(message)
            case LinkRecord():
                self.link.add(message)
            case Event():
                self._on_event(message)

    @property
    def commands(self) -> tuple[CommandSummary, ...]:
        """The commands so far, by id."""
        return self._commands.commands

    def newest_commands(self, most: int) -> tuple[CommandSummary, ...]:
        """Return the last `most` commands that were issued, by id."""
        return self._commands.newest(most)

    @property
    def round_trip_ns(self) -> int | None:
        """The round trip of the newest command that was acknowledged [ns]; None without one."""
        return self._commands.round_trip_ns

    @property
    def waypoints(self) -> tuple[WaypointSummary, ...]:
        """The waypoints of the mission, with their status so far."""
        return self._waypoints.waypoints

    @property
    def returns(self) -> tuple[ReturnHome, ...]:
        """The returns home so far."""
        return self._returns.returns

    def truth(self, most: int) -> Track:
        """Return where the robot has been so far, in about `most` rows."""
        return self._truth.track(most)

    def belief(self, most: int) -> Track:
        """Return where telemetry has reported the robot so far, in about `most` rows."""
        return self._belief.track(most)

    def summary(self) -> FlightSummary:
        """Return the summary so far."""
        outcome, reason, ended_ns = self._ending()
        return FlightSummary(
            outcome=outcome,
            reason=reason,
            ended_ns=ended_ns,
            steps=self._steps,
            waypoints=self.waypoints,
            places=self._waypoints.places,
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
            link=self.link.summary(self.now_ns),
            setting=self.setting,
        )

    def _ending(self) -> tuple[str, str, int]:
        for event in reversed(self.events):
            if event.kind is EventKind.MISSION_ENDED:
                outcome, _, reason = event.text.partition(": ")
                return outcome, reason, event.time_ns
        return UNFINISHED, "the log has no end", self.now_ns

    def _on_state(self, state: State) -> None:
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

    def _on_reward(self, reward: Reward) -> None:
        for name, value in reward.terms:
            self._reward[name] = self._reward.get(name, 0.0) + value
        self._reward_total += reward.total

    def _on_telemetry(self, frame: Telemetry) -> None:
        self.now_ns = max(self.now_ns, frame.received_ns)
        if self.telemetry is None or frame.issued_ns >= self.telemetry.issued_ns:
            self.telemetry = frame
        self._returns.on_report(frame)
        if is_on_map(frame.x_m, frame.y_m, frame.speed_mps):
            self._belief.add(frame.issued_ns, frame.received_ns, frame.x_m, frame.y_m, frame.speed_mps)
        else:
            self._frames_off_map += 1
        for status in frame.commands:
            self._commands.on_status(status, frame)
        self._waypoints.on_report(frame)

    def _on_ack(self, ack: Ack) -> None:
        self.now_ns = max(self.now_ns, ack.received_ns)
        self._commands.on_ack(ack)
        self._returns.on_report(ack)

    def _on_stage(self, it: CommandStage) -> None:
        self.now_ns = max(self.now_ns, it.time_ns)
        self._returns.on_stage(it, self._commands.on_stage(it).kind)

    def _on_event(self, event: Event) -> None:
        self.now_ns = max(self.now_ns, event.time_ns)
        self.events.append(event)
        for part in (self._commands, self._waypoints, self._returns, self.link, self._effort):
            part.on_event(event)


class OperatorView:
    """A sink that keeps of a flight what the operator knows.

    Attributes:
        flight: what is known; a waypoint counts as reached from when telemetry reports it.
        now_ns: the latest time on the operator's clock.
    """

    def __init__(self, waypoints: Iterable[PlannedWaypoint] = (), setting: MissionSetting | None = None) -> None:
        """Begin with the waypoints of the mission, and what else it has fixed beforehand."""
        self.flight = FlightSummaryBuilder(waypoints, setting or MissionSetting())
        self.now_ns = 0
        self._reached: set[int] = set()

    def __call__(self, message: Message) -> None:
        """Take one message; what happens on board or on the link is left out."""
        match message:
            case Telemetry():
                self.flight(message)
                for index in message.reached:
                    self._reach(index, message)
            case Ack() | Event(clock=Clock.OPERATOR) | CommandStage(clock=Clock.OPERATOR):
                self.flight(message)
        self.pass_time(self.flight.now_ns)

    def pass_time(self, now_ns: int) -> None:
        """Take the time that it is on the operator's clock."""
        self.now_ns = self.flight.now_ns = max(self.now_ns, now_ns)

    def _reach(self, index: int, frame: Telemetry) -> None:
        if index not in self._reached:
            self._reached.add(index)
            text = f"waypoint {index + 1} reached"
            self.flight(Event(frame.issued_ns, EventKind.WAYPOINT_REACHED, Clock.OPERATOR, Severity.INFO, text, index))
