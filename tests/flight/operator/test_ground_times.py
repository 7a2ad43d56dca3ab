"""What the ground works out of its link: when an answer is due, and when a command leaves."""

from __future__ import annotations

from waypointctl.flight.link.contacts import Contacts, Window
from waypointctl.flight.link.direction import Direction
from waypointctl.flight.link.impairments import drawn_jitter, fixed_delay, uniform_jitter
from waypointctl.flight.operator.timing import answer_time, leaving_time, patience_ns
from waypointctl.seeding import stream


def direction(delay: int, jitter: int, window: Window | None = None) -> Direction[int]:
    contacts = Contacts([window or Window(0, 1 << 60)])
    return Direction(delay=fixed_delay(delay), jitter=uniform_jitter(jitter, stream(0, "j")), contacts=contacts)


def test_an_answer_is_due_after_both_delays_both_jitters_the_robots_time_and_the_margin() -> None:
    up, down = direction(1_000, 100), direction(2_000, 50)
    assert answer_time(up, down, 20, 7)(5) == 5 + 1_000 + 100 + 20 + 2_000 + 50 + 7
    assert patience_ns(down, 7) == 7 + 2 * 50
    assert patience_ns(Direction[int](), 7) == 7
    for most_ns in (0, -5):
        assert patience_ns(Direction[int](jitter=drawn_jitter([-9, most_ns], stream(0, "j"))), 7) == 7


def test_an_answer_waits_for_the_contact_back_and_takes_its_airtime() -> None:
    down = direction(2_000, 50, Window(5_000, 6_000, 8e9))
    assert answer_time(direction(1_000, 100), down, 20, 7)(0) == 5_000 + 64 + 2_000 + 50 + 7
    assert answer_time(direction(1_000, 100), down, 20, 7)(5_000) is None


def test_a_command_leaves_when_a_contact_is_open() -> None:
    up = direction(0, 0, Window(100, 500, 8e9))
    assert [leaving_time(up)(at) for at in (0, 100, 300, 450)] == [164, 164, 364, None]
