"""Any commands in any order, with any arguments, at any time and place: the executive stays in its table."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from tests.budget import examples
from tests.flight.executive.rig import SECOND
from tests.flight.executive.stream import IMPOSSIBLE, PLACES, WAYPOINTS, CountingMachine, Stream
from waypointctl.flight.executive.state_machine import TRANSITIONS
from waypointctl.log.messages import Command, CommandKind

THENS = ["abort", "skip", "hold", "return_home"]
ON_LOSS = ["finish", "hold", "return_home"]
ON_BREACH = ["hold", "return_home", "abort"]
BRINGING = [CommandKind.UPLOAD_PLAN, CommandKind.APPEND_PLAN]
TOUCHING = [kind for kind in CommandKind if kind not in BRINGING]
TIMES_NS = st.one_of(st.just(-1), st.integers(-5, 200).map(lambda tenths: tenths * SECOND // 10))
IDS = st.one_of(st.integers(-1, 3), st.integers(995, 1015))  # what is issued soundly counts from 1001

anything = st.builds(
    Command,
    id=IDS,
    kind=st.sampled_from(CommandKind),
    waypoints=st.lists(st.sampled_from(WAYPOINTS * 4 + IMPOSSIBLE), max_size=4).map(tuple),
    on_failure=st.sampled_from(["", "dance", *THENS]),
    issued_ns=st.just(0),
    received_ns=st.just(0),
    attempt=st.integers(1, 3),
    released=st.sampled_from([-1, -1, 0, 1, 2, 9, -7]),
    target_id=IDS,
    value=st.sampled_from([0.3, 1.0, 5.0, 0.0, -1.0, float("nan"), float("inf"), 1e9]),
    not_before_ns=TIMES_NS,
    expires_ns=TIMES_NS,
)
# Sound ones too, or little would ever be under way.
plans = st.builds(
    lambda kind, waypoints, released, on_failure: Command(
        0, kind, waypoints, on_failure, 0, 0, released=min(released, len(waypoints))
    ),
    st.sampled_from(BRINGING),
    st.lists(st.sampled_from(WAYPOINTS), min_size=1, max_size=4).map(tuple),
    st.sampled_from([-1, -1, 0, 1, 2]),
    st.sampled_from(["", *THENS]),
)
touches = st.builds(
    lambda kind, target_id, released: Command(0, kind, (), "", 0, 0, target_id=target_id, released=released, value=2.0),
    st.sampled_from(TOUCHING),
    st.integers(1001, 1010),
    st.sampled_from([-1, 1, 2, 3]),
)


class Fuzzed(RuleBasedStateMachine):
    """A stream that hypothesis makes up."""

    def __init__(self) -> None:
        super().__init__()
        self.stream = Stream()

    @initialize(
        rules=st.fixed_dictionaries(
            {
                "retries": st.integers(0, 2),
                "then": st.sampled_from(THENS),
                "slip_m": st.sampled_from([0.0, 1.0]),
                "stuck_fails": st.booleans(),
                "link_loss_ns": st.sampled_from([0, 4 * SECOND]),
                "on_link_loss": st.sampled_from(ON_LOSS),
                "fenced": st.booleans(),
                "on_breach": st.sampled_from(ON_BREACH),
            }
        )
    )
    def take_rules(self, rules: dict[str, object]) -> None:
        self.stream = Stream(**rules)  # type: ignore[arg-type]

    @rule(command=anything)
    def send_anything(self, command: Command) -> None:
        self.stream.obey(command)

    @rule(command=plans)
    def send_plan(self, command: Command) -> None:
        self.stream.issue(command)

    @rule(command=touches)
    def send_touch(self, command: Command) -> None:
        self.stream.issue(command)

    @rule(command=touches, wait=st.integers(1, 5), room=st.integers(0, 5))
    def send_for_later(self, command: Command, wait: int, room: int) -> None:
        at_ns = self.stream.now_ns + wait * SECOND
        self.stream.issue(replace(command, not_before_ns=at_ns, expires_ns=at_ns + room * SECOND))

    @rule(command=st.one_of(plans, touches), wait=st.sampled_from([None, None, 1, 2, 5]))
    def send_what_will_be_late(self, command: Command, wait: int | None) -> None:
        at_ns = -1 if wait is None else self.stream.now_ns + wait * SECOND
        self.stream.withhold(replace(command, not_before_ns=at_ns))

    @rule(part=st.floats(0.0, 0.999))
    def deliver(self, part: float) -> None:
        self.stream.deliver(part)

    @rule()
    def send_heartbeat(self) -> None:
        self.stream.rig.executive.on_contact(self.stream.now_ns)

    @rule()
    def send_action(self) -> None:
        self.stream.rig.executive.on_action(self.stream.now_ns)

    @rule(place=st.sampled_from(PLACES))
    def move(self, place: tuple[float, float]) -> None:
        self.stream.move(place)

    @rule()
    def arrive(self) -> None:
        self.stream.arrive()

    @rule(ticks=st.sampled_from([1, 50, 100, 300, 1000]))
    def wait(self, ticks: int) -> None:
        self.stream.look(ticks)

    @rule(part=st.floats(0.0, 0.999))
    def rest(self, part: float) -> None:
        self.stream.rest(part)

    @rule(steady=st.sampled_from([True] * 19 + [False]))
    def stumble(self, steady: bool) -> None:
        self.stream.look(fell=not steady)

    @invariant()
    def all_is_well(self) -> None:
        self.stream.check()

    def teardown(self) -> None:
        self.stream.close()


TestFuzzed = Fuzzed.TestCase
TestFuzzed.settings = settings(max_examples=examples(40), stateful_step_count=30, deadline=None)


@pytest.mark.slow
def test_seeded_streams_take_every_transition_there_is() -> None:
    """A table with a row that nothing can take would be a table of something else."""
    CountingMachine.taken.clear()
    for seed in range(1500):
        _run_seeded(random.Random(seed))
        never = [f"{mode} {signal}" for mode, signal in TRANSITIONS if not CountingMachine.taken[mode, signal]]
        if not never and seed >= examples(1500):
            return
    pytest.fail(f"never taken: {never}")


def _run_seeded(draw: random.Random) -> None:
    stream = Stream(
        fenced=draw.random() < 0.5,
        retries=draw.randrange(2),
        then=draw.choice(THENS),
        slip_m=draw.choice([0.0, 1.0]),
        stuck_fails=draw.random() < 0.3,
        link_loss_ns=draw.choice([0, 4 * SECOND]),
        on_link_loss=draw.choice(ON_LOSS),
        on_breach=draw.choice(ON_BREACH),
    )
    for _ in range(60):
        _do_something(stream, draw)
    stream.check()
    stream.close()


def _do_something(stream: Stream, draw: random.Random) -> None:
    dice = draw.random()
    if dice < 0.15:
        waypoints = tuple(draw.choices(WAYPOINTS, k=draw.randint(1, 4)))
        kind, released = draw.choice(BRINGING), draw.choice([-1, -1, 0, 1])
        send = draw.choice([stream.issue, stream.issue, stream.withhold])
        at_ns = draw.choice([-1, -1, stream.now_ns + 2 * SECOND])
        failing = draw.choice(["", "hold", *THENS])
        send(Command(0, kind, waypoints, failing, 0, 0, released=released, not_before_ns=at_ns))
    elif dice < 0.4:
        kind, target = draw.choice([*TOUCHING, CommandKind.SKIP, CommandKind.SKIP]), stream.issued - draw.randrange(4)
        waypoints = (draw.choice(WAYPOINTS),) if kind is CommandKind.GO_TO else ()
        touch = Command(0, kind, waypoints, "", 0, 0, target_id=target, released=draw.randint(-1, 3), value=2.0)
        at_ns = stream.now_ns + draw.randrange(3) * SECOND
        send = draw.choice([stream.issue, stream.issue, stream.issue, stream.withhold])
        send(replace(touch, not_before_ns=at_ns, expires_ns=at_ns + draw.choice([0, 2, 50]) * SECOND))
    elif dice < 0.5:
        _pause(stream, draw)
    elif dice < 0.55:
        stream.deliver(draw.random())
    elif dice < 0.7:
        stream.arrive()
    elif dice < 0.8:
        stream.move(draw.choice(PLACES))
    elif dice < 0.9:
        stream.look(draw.choice([1, 50, 100, 300]))
    elif dice < 0.94:
        stream.rest(draw.random())
    elif dice < 0.97:
        stream.rig.executive.on_action(stream.now_ns)
    else:
        stream.look(fell=draw.random() < 0.1)


def _pause(stream: Stream, draw: random.Random) -> None:
    """Send a hold and what may follow it, with time between."""
    after = draw.choice([CommandKind.RESUME, CommandKind.RESUME, CommandKind.SKIP, CommandKind.ABORT])
    for kind in (CommandKind.HOLD, after):
        stream.issue(Command(0, kind, (), "", 0, 0))
        stream.look(draw.choice([1, 50]))
