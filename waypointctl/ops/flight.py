"""A flight under way: the robot, the operator, the link between them, and the clock."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from waypointctl.log.messages import Ack, Clock, Command, ConsoleInput, Event, EventKind, Severity, Telemetry
from waypointctl.mission.mission import Mission
from waypointctl.ops.executive.rules import FALL, rules_of
from waypointctl.ops.ground.build import answer_time, patience_ns, station_for
from waypointctl.ops.ground.console import order_from
from waypointctl.ops.ground.line_source import QUIT, LineSource, Nobody
from waypointctl.ops.ground.standstill import why_it_stands
from waypointctl.ops.link.build import direction
from waypointctl.ops.link.direction import Direction
from waypointctl.ops.link.frames import BodyFrame, ControlFrame, Heartbeat
from waypointctl.ops.link.in_flight import link_state
from waypointctl.ops.link.logged import DOWN, UP, LoggedDirection
from waypointctl.ops.reporter import Downlink, Reporter
from waypointctl.ops.sink import Sink
from waypointctl.ops.vehicle import Vehicle
from waypointctl.policy.protocol import Policy
from waypointctl.seeding import stream
from waypointctl.sim.robots import Robot
from waypointctl.task.observation import NOISE_SIZE
from waypointctl.task.start import Start
from waypointctl.units import NS_PER_S, ns, seconds

CHECKPOINT_PERIOD_NS: Final = 10 * NS_PER_S
SILENT: Final = "the robot rests, and nothing is left that the operator could hear or send"
UNTOLD: Final = ", and nobody tells it to go on"


@dataclass(frozen=True, slots=True)
class FlightResult:
    """How a flight ended, as the operator knows it.

    Attributes:
        outcome: "success", "failure" or "interrupted".
        reason: why, in a few words.
        waypoints_reached: that the operator has heard of.
        waypoints_total: in the mission.
        sim_time_ns: on the operator's clock, from mission start.
    """

    outcome: str
    reason: str
    waypoints_reached: int
    waypoints_total: int
    sim_time_ns: int


class Flight:
    """Everything that changes during a flight, and the steps of its loop."""

    def __init__(
        self, mission: Mission, policy: Policy, sink: Sink, robot: Robot, console: LineSource | None = None
    ) -> None:
        """Set the robot at its start; nothing has been sent yet."""
        self._console = console or Nobody()
        link, files, seed = mission.link, mission.files, mission.seed
        self._mission = mission
        self._sink = sink
        self._period_ns = robot.control_period_ns
        up: Direction[Command | ControlFrame | Heartbeat] = direction(link.up, files, seed, "link.up")
        down: Direction[Ack | Telemetry | BodyFrame] = direction(link.down, files, seed, "link.down")
        self._uplink, self._downlink = LoggedDirection(up, UP, sink), LoggedDirection(down, DOWN, sink)
        noise = stream(seed, "course", 0).uniform(-1.0, 1.0, NOISE_SIZE)  # as the env draws it, like the start
        patience = patience_ns(down, ns(mission.commands.margin_s))
        answer_by = answer_time(up, down, self._period_ns, ns(mission.commands.margin_s))
        self._station = station_for(
            mission, policy, noise, sink, self._uplink.send, self._uplink.send, answer_by, patience
        )
        self._vehicle = Vehicle(robot, policy, sink, _reporter(mission, self._downlink), rules_of(mission))
        self._vehicle.place(*start_of(mission).draw(robot, stream(seed, "start", 0)), noise)
        self._now_ns = 0
        self._checkpoint_ns = 0
        self._ground_ns = 0  # when the operator last heard or did anything

    @property
    def over(self) -> bool:
        """Whether the operator has ended the mission, its time is up, or nothing is left that could happen."""
        return self._station.finished or self._out_of_time or self._is_silent

    @property
    def _out_of_time(self) -> bool:
        limit_s = self._mission.expect.max_time_s
        return limit_s is not None and self._now_ns > ns(limit_s)

    @property
    def _is_silent(self) -> bool:
        """Whether the robot rests for good, and the operator waits for what will never come: an answer was lost."""
        if not self._vehicle.plans_nothing or self._station.console_is_open:
            return False
        if self._downlink.direction.next_arrival_ns is not None and not self._heard_of_rest:
            return False
        return self._station.plans_nothing and all(
            isinstance(one, Heartbeat) for _, one in self._uplink.direction.under_way
        )

    @property
    def _heard_of_rest(self) -> bool:
        """Whether a frame has arrived that was sent while the robot rested."""
        frame = self._station.belief.telemetry
        return frame is not None and frame.issued_ns > self._vehicle.rests_since_ns

    def begin(self) -> None:
        """Let the operator send what it sends at mission start."""
        self._announce(0, EventKind.MISSION_STARTED, f"mission {self._mission.name} started")
        if self._console.is_open:
            self._station.console_is_open = True
            self._announce(0, EventKind.CONSOLE_OPENED, "console opened")
        self._station.begin()

    def listen(self) -> None:
        """Let the ground take what has been typed at its console by now."""
        for text in self._console.lines(self._now_ns):
            self._ground_ns = self._now_ns
            self._sink(ConsoleInput(self._now_ns, text))
            if text == QUIT:
                self._station.console_is_open = False
                self._announce(self._now_ns, EventKind.CONSOLE_CLOSED, "console closed")
            else:
                self._station.issue(self._now_ns, [order_from(text, self._mission)])

    def exchange(self) -> None:
        """Let the ground live up to now, and the robot obey what has arrived, until there is silence."""
        while not self._station.finished:
            at_ns = self._next_on_ground_ns
            if at_ns is not None and at_ns <= self._now_ns:
                self._live_on_ground(at_ns)
                continue
            arrived = next(self._uplink.due(self._now_ns), None)
            if arrived is None:
                return
            if isinstance(arrived, Command):
                self._sink(arrived)
            self._vehicle.obey(self._now_ns, arrived)

    @property
    def _next_on_ground_ns(self) -> int | None:
        """When the ground hears something or wants to act [ns]; None for never."""
        arrival_ns, wake_ns = self._downlink.direction.next_arrival_ns, self._station.wake_ns
        if arrival_ns is None or wake_ns is None:
            return wake_ns if arrival_ns is None else arrival_ns
        return min(arrival_ns, wake_ns)

    def _live_on_ground(self, at_ns: int) -> None:
        """Let the ground hear what arrives at this moment; if nothing does, let it do what it has planned."""
        self._ground_ns = at_ns
        heard = next(self._downlink.due(at_ns), None)
        if heard is None:
            self._station.wake(at_ns)
            return
        if not isinstance(heard, BodyFrame):
            self._sink(heard)
            self._station.hear(at_ns, heard)
            return
        control = self._station.see(at_ns, heard)
        if control is not None:
            self._sink(control)
            self._uplink.send(
                at_ns, lambda arrives_ns: ControlFrame(control.step, control.commanded, at_ns, arrives_ns)
            )

    def sense(self) -> None:
        """Let the robot look at where it is."""
        self._vehicle.sense(self._now_ns)

    def act(self) -> None:
        """Let the robot act for one control period, or sleep until something happens."""
        if self._vehicle.rests(self._now_ns):
            self._sleep()
            return
        if self._now_ns >= self._checkpoint_ns:
            link = link_state(self._uplink.direction, self._downlink.direction)
            self._vehicle.log_checkpoint(self._now_ns, link | {"ground": self._station.state()})
            self._checkpoint_ns = self._now_ns - self._now_ns % CHECKPOINT_PERIOD_NS + CHECKPOINT_PERIOD_NS
        self._vehicle.act(self._now_ns)
        self._now_ns += self._period_ns

    def _sleep(self) -> None:
        """Go on to the next control step at which something can happen."""
        limit_s = self._mission.expect.max_time_s
        times = (
            self._next_on_ground_ns,
            self._uplink.direction.next_arrival_ns,
            self._vehicle.next_ns(self._now_ns),
            None if limit_s is None else ns(limit_s) + 1,
        )
        next_ns = min(time_ns for time_ns in times if time_ns is not None)
        wake_ns = self._first_step(next_ns)
        self._now_ns = min(wake_ns, self._first_step(self._console.asleep(self._now_ns, wake_ns)))

    def _first_step(self, time_ns: int) -> int:
        """Return the first control step to come that is not before a time [ns]."""
        steps = -(-(time_ns - self._now_ns) // self._period_ns)
        return self._now_ns + max(steps, 1) * self._period_ns

    def end(self) -> FlightResult:
        """Close the flight with the outcome that the operator's belief gives it."""
        expect = self._mission.expect
        total = self._mission.num_legs
        reached = len(self._station.reached)
        wanted = total if expect.reached == "all" else expect.reached
        ended_ns = self._ground_ns if self._station.finished else self._now_ns
        facts = f"{reached} of {total} waypoints reached in {seconds(ended_ns):.2f} s"
        stands = why_it_stands(self._mission, self._station.belief.telemetry)
        if self._is_silent and not self._station.operator.finished:
            return self._close("failure", f"{stands + UNTOLD if stands else SILENT}: {facts}", ended_ns)
        if not self._station.operator.finished or (expect.max_time_s is not None and ended_ns > ns(expect.max_time_s)):
            late = f"longer than {expect.max_time_s:g} s" + (f"; {stands}" if stands else "")
            return self._close("failure", f"{late}: {facts}", ended_ns)
        if reached < wanted or self._station.verdict == FALL:
            return self._close(
                "failure", f"{self._station.verdict or 'not all reached'}: {facts}, {wanted} expected", ended_ns
            )
        return self._close("success", facts, ended_ns)

    def interrupt(self) -> FlightResult:
        """Close the flight because somebody asked for it."""
        reached = len(self._station.reached)
        total = self._mission.num_legs
        return self._close("interrupted", f"{reached} of {total} waypoints reached", self._now_ns)

    def _close(self, outcome: str, reason: str, ended_ns: int) -> FlightResult:
        self._vehicle.close(self._now_ns)
        self._vehicle.log_state(self._now_ns)
        severity = Severity.INFO if outcome == "success" else Severity.ERROR
        self._announce(ended_ns, EventKind.MISSION_ENDED, f"{outcome}: {reason}", severity)
        return FlightResult(outcome, reason, len(self._station.reached), self._mission.num_legs, ended_ns)

    def _announce(
        self, now_ns: int, kind: EventKind, text: str, severity: Severity = Severity.INFO, command_id: int = -1
    ) -> None:
        self._sink(Event(now_ns, kind, Clock.OPERATOR, severity, text, command_id=command_id))


def _reporter(mission: Mission, downlink: Downlink) -> Reporter:
    telemetry = mission.telemetry
    period_ns, beacon_ns = ns(1 / telemetry.rate_hz), ns(telemetry.beacon_s)
    return Reporter(downlink, period_ns, beacon_ns, every_state=mission.autonomy == "joint")


def start_of(mission: Mission) -> Start:
    """Return where the mission begins, as the task draws it."""
    x_m, y_m = mission.start.position_m
    return Start(position_m=(x_m, y_m), heading_rad=math.radians(mission.start.heading_deg))
