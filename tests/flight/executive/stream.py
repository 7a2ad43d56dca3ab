"""An executive under a stream of commands, and what has to hold after each of them, whatever they are."""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import replace
from typing import Any, ClassVar, Final

from tests.flight.executive.rig import SECOND, A, B, C, Rig
from waypointctl.flight.executive.rules import Circle, Fence, home_at
from waypointctl.flight.executive.state_machine import Signal, StateMachine
from waypointctl.log.messages import FINAL_STAGES, Command, CommandKind, CommandStage, EventKind, Mode, Stage

TICK_NS: Final = 20_000_000

# What may become of a command on board, as the names of its stages one after the other.
LIVES: Final = re.compile(
    "received( (rejected|expired|skipped|cancelled)| accepted( (cancelled|expired|skipped|superseded|completed|failed)"
    "| started( (completed|failed|cancelled|superseded|expired))?)?)?"
)
AT_WAYPOINT: Final = {Mode.NAVIGATING, Mode.HOLDING, Mode.OBSERVING}
BY_COMMAND: Final = re.compile(r"by command (\d+)")
FOR_EVER_NS: Final = 10**18
# An older command of these kinds is not begun any more once a newer one that follows it was obeyed.
ENDING: Final = {CommandKind.UPLOAD_PLAN, CommandKind.GO_TO, CommandKind.RETURN_HOME, CommandKind.ABORT}
DONE_WITH_BY: Final = {kind: ENDING for kind in CommandKind if kind not in (CommandKind.CANCEL, CommandKind.ABORT)} | {
    CommandKind.HOLD: ENDING | {CommandKind.RESUME},
    CommandKind.RESUME: ENDING | {CommandKind.HOLD},
}
NOTHING_UNDER_WAY: Final = {Mode.IDLE, Mode.DONE, Mode.FAILED, Mode.FALLEN, Mode.TELEOPERATED}

WAYPOINTS: Final = (
    A,
    B,
    replace(C, task="observe"),
    replace(A, index=3, name="d", x_m=-5.0, hold_ns=3 * SECOND, task="observe"),
    replace(B, index=-1, name="ad hoc", x_m=2.0, y_m=2.0, timeout_ns=2 * SECOND),
)
IMPOSSIBLE: Final = (
    replace(A, x_m=float("nan")),
    replace(A, y_m=float("inf")),
    replace(A, tolerance_m=0.0),
    replace(A, acceptance="square"),
    replace(A, timeout_ns=-1),
    replace(A, hold_ns=-1),
    replace(A, task="dig"),
    replace(A, x_m=500.0),  # outside the fence, where there is one
)
# Waypoints, in their slips, in the pit, and out of the yard.
PLACES: Final = ((0.0, 0.0), (5.0, 0.0), (5.0, 5.0), (-5.0, 0.0), (2.0, 2.0), (5.7, 0.0), (1.5, 1.5), (30.0, 30.0))
FENCE: Final = Fence((Circle("yard", (0.0, 0.0), 20.0),), (Circle("pit", (1.5, 1.5), 0.2),))


class CountingMachine(StateMachine):
    """The machine, and how often each of its transitions was taken, by anyone."""

    taken: ClassVar[Counter[tuple[Mode, Signal]]] = Counter()

    def signal(self, signal: Signal) -> None:
        before = self.mode
        super().signal(signal)
        self.taken[before, signal] += 1


class Stream:
    """The rig, its clock, its place, and what has been sent."""

    def __init__(self, *, fenced: bool = False, **rules: Any) -> None:
        home = replace(home_at(0.0, 0.0), timeout_ns=6 * SECOND)
        self.rig = Rig(fence=FENCE if fenced else Fence(), stall_ns=3 * SECOND, home=home, **rules)
        self.rig.executive._execution.machine = CountingMachine()
        self.now_ns = 0
        self.place = PLACES[0]
        self.rig.on_stage = self._note_releases
        self.commands: dict[int, Command] = {}
        self.released: set[int] = set()
        self.releases: set[int] = set()  # commands
        self.under_way: list[Command] = []
        self.seen: set[int] = set()
        self.arrivals = 0
        self.issued = 1000

    def issue(self, command: Command) -> None:
        """Send a command under an id that no other has."""
        self.withhold(command)
        self.obey(self.under_way.pop())

    def withhold(self, command: Command) -> None:
        """Send a command under an id that no other has; it arrives later, perhaps after newer ones."""
        self.issued += 1
        self.under_way.append(replace(command, id=self.issued))

    def deliver(self, part: float) -> None:
        """Let a command arrive that was withheld: any of them, by `part` of 1."""
        if self.under_way:
            self.obey(self.under_way.pop(int(part * len(self.under_way))))

    def obey(self, command: Command) -> None:
        """Send a command as it is; one whose id has arrived before is answered, and changes nothing."""
        command = replace(command, received_ns=self.now_ns)
        before = self.rig.stages_of(command.id), len(self.rig.reminders)
        self.arrivals += 1
        self.commands.setdefault(command.id, command)
        self.rig.executive.execute(self.now_ns, command)
        if command.id in self.seen:
            assert (self.rig.stages_of(command.id), len(self.rig.reminders)) == (before[0], before[1] + 1)
            assert self.rig.reminders[-1].stage is self.rig.stage(command.id)
        self.seen.add(command.id)

    def look(self, ticks: int = 1, *, fell: bool = False) -> None:
        """Let time pass, then let it look at the world."""
        self.now_ns += ticks * TICK_NS
        self.rig.sense(self.now_ns / SECOND, self.place, fell=fell)

    def move(self, place: tuple[float, float]) -> None:
        """Put the robot somewhere."""
        self.place = place
        self.look()

    def arrive(self) -> None:
        """Put the robot where it wants to be."""
        target = self.rig.executive.target
        self.move(self.place if target is None else (target.x_m, target.y_m))

    def rest(self, part: float) -> None:
        """Let a robot that stands close its eyes until something is due: nothing happens before."""
        due_ns = self.rig.executive.next_ns(self.now_ns)
        until_ns = self.now_ns + 500 * SECOND if due_ns is None else due_ns
        at_ns = self.now_ns + int(part * (until_ns - self.now_ns))
        if at_ns > self.now_ns:
            said = len(self.rig.stages_said), len(self.rig.events), self.rig.executive.mode
            self.now_ns = at_ns
            self.rig.sense(self.now_ns / SECOND, self.place)
            assert said == (len(self.rig.stages_said), len(self.rig.events), self.rig.executive.mode)

    def check(self) -> None:
        """Hold what is so against what has to be so."""
        rig, executive = self.rig, self.rig.executive
        lives = {command_id: rig.stages_of(command_id) for command_id in self.seen}
        for life in lives.values():
            assert LIVES.fullmatch(" ".join(life)), life
        self._check_waypoints()
        self._check_order()
        unfinished = {i for i, life in lives.items() if life[-1] not in FINAL_STAGES}
        started = {i for i in unfinished if lives[i][-1] is Stage.STARTED}
        if executive.mode is Mode.FALLEN:
            assert not unfinished
        if executive.mode in NOTHING_UNDER_WAY:
            assert not started
        if executive.mode in AT_WAYPOINT | {Mode.WAITING}:
            assert executive.state()["command_id"] in started
        times = [it.time_ns for it in rig.stages_said]
        assert times == sorted(times)
        state = executive.state()
        assert json.loads(json.dumps(state)) == state

    def _check_waypoints(self) -> None:
        executive = self.rig.executive
        assert set(executive.reached) <= self.released
        assert len(set(executive.reached)) == len(executive.reached)
        target = executive.target
        if executive.mode in AT_WAYPOINT | {Mode.RETURNING}:
            assert target is not None
            assert executive.goals[0, 0].tolist() == [target.x_m, target.y_m]
        elif executive.mode not in (Mode.PAUSED, Mode.SAFE):
            assert target is None

    def _check_order(self) -> None:
        """Nothing was begun that a newer command had done with, and no abort ended what follows it."""
        obeyed: list[tuple[Command, int]] = []
        for it in self.rig.stages_said:
            command = self.commands[it.command_id]
            start_ns, aborts = _start_ns(command), command.kind is CommandKind.ABORT
            if it.stage is Stage.STARTED and command.kind in DONE_WITH_BY:
                for newer, newer_start_ns in obeyed:
                    follows = newer.id > command.id and newer_start_ns >= command.not_before_ns
                    assert not (follows and newer.kind in DONE_WITH_BY[command.kind]), (it, newer)
            if it.stage is Stage.STARTED or (aborts and it.stage is Stage.SKIPPED):
                obeyed.append((command, FOR_EVER_NS if aborts else start_ns))
            by = BY_COMMAND.fullmatch(it.reason) if it.stage is Stage.CANCELLED else None
            ending = None if by is None else self.commands[int(by[1])]
            if ending is not None and ending.kind is CommandKind.ABORT and ending.id < command.id:
                assert command.kind is CommandKind.APPEND_PLAN or start_ns < ending.not_before_ns, it

    def close(self) -> None:
        """End the flight: every command that was received has come to one end."""
        self.rig.executive.close(self.now_ns)
        for command_id in self.seen:
            life = self.rig.stages_of(command_id)
            assert [stage in FINAL_STAGES for stage in life] == [False] * (len(life) - 1) + [True]
        received = self.rig.kinds.count(EventKind.COMMAND_RECEIVED)
        assert received == len(self.seen) == self.arrivals - len(self.rig.reminders)

    def _note_releases(self, stage: CommandStage) -> None:
        """Remember every waypoint that a command releases, when it does."""
        command = self.commands[stage.command_id]
        indices = [waypoint.index for waypoint in command.waypoints]
        if stage.stage is Stage.STARTED and command.kind is CommandKind.RELEASE:
            self.releases.add(command.id)
            self._release(command.released, [])
        elif stage.stage is Stage.ACCEPTED:
            released = indices if command.released < 0 else indices[: command.released]
            self.released.update(released)
            for newer in (self.commands[command_id] for command_id in self.releases if command_id > command.id):
                self._release(newer.released, indices)

    def _release(self, count: int, added: list[int]) -> None:
        """Remember a release of the plan that there is and what is added to it, or replaces it."""
        plan: Any = self.rig.executive.state()["plan"]
        planned = [item["waypoint"]["index"] for item in plan["items"]]
        for indices in (added, planned + added):
            self.released.update(indices if count < 0 else indices[:count])


def _start_ns(command: Command) -> int:
    """Return when a command is to start."""
    return max(command.received_ns, command.not_before_ns)
