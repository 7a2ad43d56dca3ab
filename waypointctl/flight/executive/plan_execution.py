"""The plan under way: leg after leg, holds and observations, pauses, and the way home."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from waypointctl.flight.executive.command_ordering import CommandOrdering
from waypointctl.flight.executive.command_tracker import CommandTracker
from waypointctl.flight.executive.plan import SAVED, Leg, Plan, PlanItem
from waypointctl.flight.executive.rules import AT_HOME, RETURN_FAILED, Rules
from waypointctl.flight.executive.state_machine import RESUME_SIGNALS, SUSPENDED, UNDER_WAY, Signal, StateMachine
from waypointctl.log.messages import Clock, Event, EventKind, Mode, Severity, Stage

BY_RULE: Final = -1  # in place of a command's id: a rule sent it home


@dataclass(slots=True)
class PlanExecution:
    """What the robot is doing about its plan."""

    rules: Rules  # what it does by itself
    tracker: CommandTracker  # of its commands
    announce: Callable[[Event], None]  # takes every event
    machine: StateMachine = field(default_factory=StateMachine)  # its mode
    plan: Plan = field(default_factory=Plan)  # the waypoints on board
    ordering: CommandOrdering = field(default_factory=CommandOrdering)  # as the ground issued what has arrived
    leg: Leg | None = None  # the way to a waypoint, or home, while there is one
    stood_ns: int = 0  # when the hold or the observation began
    reached: tuple[int, ...] = ()  # indices in the mission, each once, in the order of reaching them
    # The mode to resume after a pause; None where the plan continues with its next waypoint
    suspended: Mode | None = None
    suspended_ns: int = 0  # when the pause began
    cause: str = ""  # the rule or command because of which it is stopped or returning home
    home_id: int | None = None  # the command that sent it home, or BY_RULE; None while it is not on the way home
    home_cause: str = ""  # why a rule sent it home; empty for a command
    command_id: int = -1  # the command that was under way last; -1 for none

    @property
    def mode(self) -> Mode:
        """The mode it is in."""
        return self.machine.mode

    @property
    def can_go_on(self) -> bool:
        """Whether there is anything that a pause keeps it from."""
        return self.mode in SUSPENDED and (self.home_id is not None or self.plan.current is not None)

    def proceed(self, now_ns: int) -> None:
        """Drive to the next waypoint of the plan, which has one, or wait for its release."""
        item = self.plan.current
        assert item is not None
        self.suspended, self.leg, self.cause, self.command_id = None, None, "", item.command_id
        if not self.tracker.has_started(item.command_id):
            self.tracker.advance(now_ns, item.command_id, Stage.STARTED)
        if not item.released:
            self.machine.signal(Signal.AWAIT_RELEASE)
            self.emit(now_ns, EventKind.RELEASE_AWAITED, f"waiting for the release of {item.waypoint.name}", item)
            return
        self.machine.signal(Signal.START_LEG)
        self.leg = Leg(item.waypoint, self.plan.following or item.waypoint, now_ns)
        self.emit(now_ns, EventKind.LEG_STARTED, f"driving to {item.waypoint.name}", item)

    def suspend(self, now_ns: int, signal: Signal, cause: str) -> None:
        """Stop, and keep what was under way for later; a stop for one reason may become one for another."""
        if self.mode in UNDER_WAY:
            self.suspended, self.suspended_ns = self.mode, now_ns
        self.machine.signal(signal)
        self.cause = cause
        paused = signal is Signal.PAUSE
        kind = EventKind.NAVIGATION_PAUSED if paused else EventKind.SAFE_HOLD_STARTED
        severity = Severity.INFO if paused else Severity.WARNING
        self.emit(now_ns, kind, f"stopped: {cause}", self.plan.current, severity)

    def resume(self, now_ns: int) -> None:
        """Resume what a pause interrupted; its clocks were stopped meanwhile."""
        self.emit(now_ns, EventKind.NAVIGATION_RESUMED, "navigation resumed", self.plan.current)
        signal = None if self.suspended is None else RESUME_SIGNALS.get(self.suspended)
        self.cause = "" if self.home_id is None else self.home_cause
        if signal is None:  # it waited for a release, or what was under way is over
            self.proceed(now_ns)
            return
        self.machine.signal(signal)
        self.suspended = None
        self.stood_ns += now_ns - self.suspended_ns
        if self.leg is not None:
            self.leg.shift(now_ns - self.suspended_ns)

    def skip_item(self, now_ns: int, item: PlanItem, cause: str) -> None:
        """Leave the plan's current waypoint without having reached it, or with its task undone."""
        text = f"{item.waypoint.name} skipped: {cause}"
        self.emit(now_ns, EventKind.WAYPOINT_SKIPPED, text, item, Severity.WARNING)
        self.finish_item(now_ns, item)

    def finish_item(self, now_ns: int, item: PlanItem) -> None:
        """Mark a waypoint of the plan as over; after the current one continue with the next, unless paused."""
        was_current = item is self.plan.current
        self.plan.end([item])
        if self.plan.current is None:
            self.finish(now_ns, item.command_id)
            return
        if not self.plan.has_open(item.command_id):
            self.tracker.advance(now_ns, item.command_id, Stage.COMPLETED)
        self._after_a_change(now_ns, moved_on=was_current)

    def finish(self, now_ns: int, command_id: int) -> None:
        """Stand, with all done: the command's last waypoint is over, or it is home."""
        self.machine.signal(Signal.COMPLETE)
        self.leg, self.suspended, self.home_id, self.cause = None, None, None, ""
        self.emit(now_ns, EventKind.PLAN_COMPLETED, f"command {command_id} completed", command_id=command_id)
        self.tracker.advance(now_ns, command_id, Stage.COMPLETED)

    def stay_home(self) -> None:
        """Stand at home, where a rule has sent it."""
        self.leg, self.suspended, self.home_id = None, None, None
        self.machine.signal(Signal.SAFE_HOLD)
        self.cause = AT_HOME + self.home_cause

    def retarget(self) -> None:
        """Take what has changed in the plan into the leg that is under way."""
        item = self.plan.current
        if self.leg is not None and item is not None and self.home_id is None:
            self.leg.aim(item.waypoint, self.plan.following or item.waypoint)

    def remove_command(self, now_ns: int, command_id: int, stage: Stage, reason: str) -> None:
        """Remove a command that is under way from the plan; continue with other commands, or stop."""
        before = self.plan.current
        self.plan.end(self.plan.open_items(command_id))
        if self.plan.current is None:  # nothing is left; on the way home there is no plan either
            self.stand_idle()
            self.tracker.advance(now_ns, command_id, stage, reason)
            return
        self.tracker.advance(now_ns, command_id, stage, reason)
        self._after_a_change(now_ns, moved_on=self.plan.current is not before)

    def stand_idle(self) -> None:
        """Stand, with nothing to do."""
        self.clear()
        self.machine.signal(Signal.CLEAR)

    def clear(self) -> None:
        """Forget the plan, and the way home; its commands' stages and the mode are for the caller to set."""
        self.plan, self.leg, self.suspended, self.home_id, self.cause = Plan(), None, None, None, ""

    def end_all(self, now_ns: int, stage: Stage, reason: str) -> None:
        """Clear the plan and the return home; every command that was under way gets a final stage."""
        commands = self.under_way
        self.clear()
        for command_id in commands:
            self.tracker.advance(now_ns, command_id, stage, reason)

    def fail_all(self, now_ns: int, code: str) -> None:
        """Forget the plan, and the way home; the command under way has failed, and the rest is cancelled."""
        commands = self.under_way
        self.clear()
        stage, reason = Stage.FAILED, code
        for command_id in commands:
            self.tracker.advance(now_ns, command_id, stage, reason)
            stage, reason = Stage.CANCELLED, f"plan given up: {code}"

    @property
    def under_way(self) -> list[int]:
        """The commands that have waypoints left, the current one first; or the one that sent the robot home."""
        home = [] if self.home_id is None or self.home_id == BY_RULE else [self.home_id]
        return home or self.plan.open_commands()

    def go_home(self, now_ns: int, command_id: int, cause: str = "") -> None:
        """Drive home and drop the plan; by a command, or by a rule for the cause."""
        self.machine.signal(Signal.GO_HOME)
        self.home_id = self.command_id = command_id
        self.cause = self.home_cause = cause
        self.leg = Leg(self.rules.home, self.rules.home, now_ns)
        self.emit(now_ns, EventKind.RETURN_STARTED, f"returning home: {cause}" if cause else "returning home")

    def fail(self, now_ns: int, code: str) -> None:
        """End what is under way as failed: the plan, a single goal, or the way home."""
        self.machine.signal(Signal.FAIL)
        item = self.plan.current
        kind, what = EventKind.PLAN_FAILED, "plan aborted at {}"
        if item is None:
            kind, what = EventKind.RETURN_FAILED, "return home aborted"
        elif item.alone:  # what follows is for the ground to decide, which has the rest of the plan
            what = "{} aborted"
        text = f"{what.format(item.waypoint.name if item else '')}: {code}"
        self.emit(now_ns, kind, text, item, Severity.ERROR)
        self.fail_all(now_ns, code)
        self.cause = RETURN_FAILED + code if item is None else ""

    def emit(
        self,
        now_ns: int,
        kind: EventKind,
        text: str,
        item: PlanItem | None = None,
        severity: Severity = Severity.INFO,
        command_id: int | None = None,
    ) -> None:
        """Announce an event; where no command is given, it is about the item's, or the one last under way."""
        index = -1 if item is None else item.waypoint.index
        if command_id is None:
            command_id = self.command_id if item is None else item.command_id
        self.announce(Event(now_ns, kind, Clock.ROBOT, severity, text, index, command_id))

    def _after_a_change(self, now_ns: int, *, moved_on: bool) -> None:
        """Follow a change of the plan, which has waypoints left."""
        if not moved_on:
            self.retarget()
        elif self.mode in SUSPENDED:
            self.suspended, self.leg = None, None
        else:
            self.proceed(now_ns)

    def state(self) -> dict[str, object]:
        """Return it as plain data; of many waypoints reached the newest, and how many they are."""
        newest = list(self.reached[-SAVED:])
        return {
            "mode": self.mode.value,
            "command_id": self.command_id,
            "plan": self.plan.state(),
            "leg": None if self.leg is None else self.leg.state(),
            "stood_ns": self.stood_ns,
            "reached": newest,
            **({"reached_count": len(self.reached)} if len(newest) < len(self.reached) else {}),
            "suspended": None if self.suspended is None else self.suspended.value,
            "suspended_ns": self.suspended_ns,
            "cause": self.cause,
            "home_id": self.home_id,
            "home_cause": self.home_cause,
        }
