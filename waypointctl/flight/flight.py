"""A flight under way: the robot, the operator, the link between them, and the clock."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Final

from waypointctl.flight.executive.rules import rules_of
from waypointctl.flight.link.build import direction
from waypointctl.flight.link.direction import Direction
from waypointctl.flight.link.frames import DOWN, UP, BodyFrame, ControlFrame, Heartbeat, LoggedDirection, link_state
from waypointctl.flight.navigator import Navigator
from waypointctl.flight.operator.console import QUIT, LineSource, request_from
from waypointctl.flight.operator.joint import JointOperator
from waypointctl.flight.operator.station import station_for
from waypointctl.flight.outcome import EndCondition, FlightResult, result_of
from waypointctl.flight.reporter import Reporter
from waypointctl.flight.sink import Sink
from waypointctl.flight.vehicle import Vehicle
from waypointctl.log.messages import Ack, Clock, Command, ConsoleInput, Event, EventKind, Severity, Telemetry
from waypointctl.mission.mission import Mission
from waypointctl.policy.protocol import Policy
from waypointctl.robots.robot import Robot
from waypointctl.seeding import stream
from waypointctl.task.config import draw_start
from waypointctl.task.observation import NOISE_SIZE
from waypointctl.task.plugins import Plugin
from waypointctl.units import NS_PER_S, ns

CHECKPOINT_PERIOD_NS: Final = 10 * NS_PER_S


class Flight:
    """Everything that changes during a flight, and the steps of its loop."""

    def __init__(
        self,
        mission: Mission,
        policy: Policy,
        sink: Sink,
        robot: Robot,
        console: LineSource | None = None,
        navigator: Navigator | None = None,
        plugins: Sequence[Plugin] = (),
    ) -> None:
        """Set the robot at its start; nothing has been sent yet."""
        self._console = console
        link, files, seed = mission.link, mission.files, mission.seed
        self._mission = mission
        self._sink = sink
        self._period_ns = robot.control_period_ns
        up: Direction[Command | ControlFrame | Heartbeat] = direction(link.up, files, seed, "link.up")
        down: Direction[Ack | Telemetry | BodyFrame] = direction(link.down, files, seed, "link.down")
        self._uplink, self._downlink = LoggedDirection(up, UP, sink), LoggedDirection(down, DOWN, sink)
        noise = stream(seed, "course", 0).uniform(-1.0, 1.0, NOISE_SIZE)  # as the env draws it, like the start
        joint = partial(JointOperator, mission, policy, robot, noise, plugins, sink)
        self._station = station_for(mission, joint, sink, self._uplink, down, self._period_ns)
        telemetry = mission.telemetry
        period_ns, beacon_ns = ns(1 / telemetry.rate_hz), ns(telemetry.beacon_s)
        reporter = Reporter(self._downlink, period_ns, beacon_ns, every_state=mission.autonomy == "joint")
        self._vehicle = Vehicle(robot, policy, sink, reporter, rules_of(mission), navigator, plugins)
        self._end_condition = EndCondition(
            self._station, self._vehicle.executive, reporter.changes, up, down, self._vehicle.is_still
        )
        self._vehicle.place(*draw_start(mission.start, robot, stream(seed, "start", 0)), noise)
        limit_s = mission.expect.max_time_s
        self._limit_ns = None if limit_s is None else ns(limit_s)
        self._now_ns = 0
        self._checkpoint_ns = 0
        self._ground_ns = 0  # when the operator was last active
        self._known_ns: int | None = None  # when the operator ended the mission

    @property
    def over(self) -> bool:
        """Whether everything is over, the mission's time is up, or nothing more can happen."""
        now_ns = self._now_ns
        return self._end_condition.is_done(now_ns) or self._out_of_time or self._end_condition.is_silent(now_ns)

    @property
    def _out_of_time(self) -> bool:
        return self._limit_ns is not None and self._now_ns > self._limit_ns

    def begin(self) -> None:
        """Let the operator send what it sends at mission start."""
        self._announce(0, EventKind.MISSION_STARTED, f"mission {self._mission.name} started")
        if self._console is not None and self._console.is_open:
            self._station.console_is_open = True
            self._announce(0, EventKind.CONSOLE_OPENED, "console opened")
        self._station.begin()

    def read_console(self) -> None:
        """Let the ground take what has been typed at its console by now."""
        for text in () if self._console is None else self._console.lines(self._now_ns):
            self._ground_ns = self._now_ns
            self._sink(ConsoleInput(self._now_ns, text))
            if text == QUIT:
                self._station.console_is_open = False
                self._announce(self._now_ns, EventKind.CONSOLE_CLOSED, "console closed")
            else:
                self._station.issue(self._now_ns, [request_from(text, self._mission)])
            self._note_end()

    def exchange(self) -> None:
        """Run the operator up to now and let the robot execute what has arrived, until nothing is due."""
        while not self._end_condition.is_done(self._now_ns):
            at_ns = self._next_on_ground_ns
            if at_ns is not None and at_ns <= self._now_ns:
                self._step_ground(at_ns)
                self._note_end()
                continue
            arrived = next(self._uplink.direction.due(self._now_ns), None)
            if arrived is None:
                return
            if isinstance(arrived, Command):
                self._sink(arrived)
            self._vehicle.execute(self._now_ns, arrived)

    def _note_end(self) -> None:
        """Keep when the operator ended the mission, as far as it has."""
        if not self._station.finished:
            self._known_ns = None
        elif self._known_ns is None:
            self._known_ns = self._ground_ns

    @property
    def _next_on_ground_ns(self) -> int | None:
        """When the next message arrives on the ground or the operator acts [ns]; None for never."""
        arrival_ns, wake_ns = self._downlink.direction.next_arrival_ns, self._station.wake_ns
        if arrival_ns is None or wake_ns is None:
            return wake_ns if arrival_ns is None else arrival_ns
        return min(arrival_ns, wake_ns)

    def _step_ground(self, at_ns: int) -> None:
        """Deliver what arrives on the ground at this moment; if nothing does, run what is due there."""
        self._ground_ns = at_ns
        on_contact = next(self._downlink.direction.due(at_ns), None)
        if on_contact is None:
            self._station.wake(at_ns)
            return
        if not isinstance(on_contact, BodyFrame):
            self._sink(on_contact)
            self._station.on_message(at_ns, on_contact)
            return
        control = self._station.on_state(at_ns, on_contact)
        if control is not None:
            self._sink(control)
            self._uplink.send(
                at_ns, lambda arrives_ns: ControlFrame(control.step, control.commanded, at_ns, arrives_ns)
            )

    def sense(self) -> None:
        """Update the robot's state."""
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
        times = (
            self._next_on_ground_ns,
            self._uplink.direction.next_arrival_ns,
            self._vehicle.next_ns(self._now_ns),
            None if self._limit_ns is None else self._limit_ns + 1,
        )
        wake_ns = self._first_step(min(time_ns for time_ns in times if time_ns is not None))
        if self._console is not None:
            wake_ns = min(wake_ns, self._first_step(self._console.asleep(self._now_ns, wake_ns)))
        self._now_ns = wake_ns

    def _first_step(self, time_ns: int) -> int:
        """Return the next control step at or after a time [ns]."""
        steps = -(-(time_ns - self._now_ns) // self._period_ns)
        return self._now_ns + max(steps, 1) * self._period_ns

    def end(self) -> FlightResult:
        """Close the flight with the outcome that follows from the operator's knowledge."""
        done = self._end_condition.is_done(self._now_ns)
        on_contact = done and self._now_ns - self._ground_ns < self._period_ns  # the awaited report has just arrived
        ended_ns = self._ground_ns if on_contact else self._now_ns
        late = self._out_of_time and not done
        return self._close(result_of(self._mission, self._station, ended_ns, self._known_ns, late=late))

    def interrupt(self) -> FlightResult:
        """Close the flight on request."""
        reached, total, now_ns = len(self._station.operator.reached), self._mission.num_legs, self._now_ns
        facts = f"{reached} of {total} waypoints known to be reached"
        return self._close(FlightResult("interrupted", facts, reached, total, now_ns, now_ns, self._mission.seed))

    def _close(self, result: FlightResult) -> FlightResult:
        self._vehicle.close(self._now_ns)
        self._vehicle.log_state(self._now_ns)
        severity = Severity.INFO if result.outcome == "success" else Severity.ERROR
        text = f"{result.outcome}: {result.reason}"
        self._announce(result.sim_time_ns, EventKind.MISSION_ENDED, text, severity)
        return result

    def _announce(self, now_ns: int, kind: EventKind, text: str, severity: Severity = Severity.INFO) -> None:
        self._sink(Event(now_ns, kind, Clock.OPERATOR, severity, text))
