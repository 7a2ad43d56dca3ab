from __future__ import annotations

import re
from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.budget import examples
from tests.flight.operator.missions import mission_of
from waypointctl.flight.executive.rules import rules_of
from waypointctl.flight.executive.start import wrong_arguments
from waypointctl.flight.operator.console import impossible, request_from
from waypointctl.flight.operator.requests import CommandRequest
from waypointctl.log.messages import Command, CommandKind
from waypointctl.log.topics import BY_KIND

MISSION = mission_of("defaults: {tolerance: 0.3 m, timeout: 12 s}")


def test_each_command_becomes_its_order() -> None:
    assert request_from("hold", MISSION) == CommandRequest(CommandKind.HOLD)
    assert request_from("  home ", MISSION) == CommandRequest(CommandKind.RETURN_HOME)
    assert request_from("cancel 3", MISSION) == CommandRequest(CommandKind.CANCEL, target_id=3)
    assert request_from("release 2", MISSION) == CommandRequest(CommandKind.RELEASE, released=2)
    assert request_from("tolerance 0.25", MISSION) == CommandRequest(CommandKind.SET_TOLERANCE, value=0.25)
    (place,) = request_from("goto 7 -12.5", MISSION).waypoints
    assert (place.x_m, place.y_m, place.tolerance_m, place.timeout_ns) == (7.0, -12.5, 0.3, 12_000_000_000)
    assert place.index < 0, "it is none of the mission's waypoints"


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("goto 7", "goto takes X m Y m, not '7'"),
        ("goto a b", "goto takes X m Y m, not 'a b'"),
        ("goto nan 1", "goto takes X m Y m"),
        ("goto 1 1e999", "goto takes X m Y m"),
        ("goto 1e9 0", "further than 10000 m"),
        ("hold 3", "hold takes no argument"),
        ("hold 5 s", "`goto X m Y m hold 5 s` holds at a place"),
        ("goto 3 s 4 m", "has the unit 's'; allowed are mm, cm, m, km"),
        ("goto 3 m 4 m 5 m", "goto takes X m Y m, not '3 m 4 m 5 m'"),
        ("goto 3 m 4 m hold", "hold takes a time such as 5 s, not 'nothing'"),
        ("goto 3 m 4 m hold 2 d", "goto: hold 172800 is not at least 0 s and at most 86400 s"),
        ("goto 3 m 4 m timeout 5 s hold 1 s timeout 9 s", "goto: timeout is given twice"),
        ("goto 3 m 4 m tolerance 0 m", "goto: tolerance 0 is not more than 0 m and at most 100 m"),
        ("tolerance 1 s", "has the unit 's'"),
        ("timeout 1e999 s", "timeout takes a time such as 30 s"),
        ("", "unknown command ''"),
        ("cancel", "cancel takes a whole number, not 'nothing'"),
        ("cancel 1.5", "1.5 is not a whole number"),
        ("cancel 9999999999999999999", "9999999999999999999 is too large; command numbers go up to 1,000,000,000"),
        ("cancel -9999999999999999999", "command numbers go up to 1,000,000,000"),
        ("release 9223372036854775808", "command numbers go up to 1,000,000,000"),
        ("release 1e999", "command numbers go up to 1,000,000,000"),
        ("jump", "unknown command 'jump'; commands are: goto X m Y m"),
    ],
)
def test_what_is_no_command_is_refused_with_what_there_is(line: str, said: str) -> None:
    with pytest.raises(ValueError, match=re.escape(said)):
        request_from(line, MISSION)


@pytest.mark.parametrize(
    ("line", "same"),
    [
        ("goto 3 m 4 m", "goto 3 4"),
        ("goto 300cm 0.004km", "goto 3 4"),
        ("goto 3 -4 m", "goto 3 -4"),
        ("goto\t3  m   4", "goto 3 4"),
        ("tolerance 50 cm", "tolerance 0.5"),
        ("timeout 2 min", "timeout 120"),
    ],
)
def test_quantities_are_written_as_in_mission_files(line: str, same: str) -> None:
    assert request_from(line, MISSION) == request_from(same, MISSION)


def test_a_place_may_have_its_own_hold_tolerance_and_timeout() -> None:
    (place,) = request_from("goto 3 m 4 m tolerance 20 cm hold 5 s timeout 1 min", MISSION).waypoints
    assert (place.x_m, place.y_m) == (3.0, 4.0)
    assert (place.tolerance_m, place.hold_ns, place.timeout_ns) == (0.2, 5_000_000_000, 60_000_000_000)


@given(st.text(min_size=1).filter(str.strip))
@settings(max_examples=examples(200), deadline=None)
def test_any_line_is_an_order_or_refused(line: str) -> None:
    with suppress(ValueError):  # refused; nothing else may be raised
        assert request_from(line, MISSION).words


YARD = mission_of("onboard: {geofence: {keep_in: [{center: [0 m, 0 m], radius: 20 m}]}}")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("tolerance -1", "tolerance: -1 m is not more than 0 m and at most 100 m; type tolerance 0.5 m, for instance"),
        ("tolerance 0", "tolerance: 0 m is not more than 0 m"),
        ("tolerance 101", "tolerance: 101 m is not"),
        ("timeout 0", "timeout: 0 s is not more than 0 s and at most 86400 s"),
        ("timeout 1e6", "timeout: 1e+06 s is not"),
        ("release -2", "release: -2 is not a number of waypoints; type 0 or more, or -1 for all"),
        ("goto 30 0", "goto: (30, 0) is outside keep-in; the mission's geofence allows no goal there"),
    ],
)
def test_what_can_never_be_obeyed_is_not_sent(line: str, said: str) -> None:
    request = request_from(line, YARD)
    assert impossible(request, YARD).startswith(said)
    assert wrong_arguments(request.command(1, 1, 0, 0), rules_of(YARD).fence), "the robot would reject it"


@pytest.mark.parametrize("line", ["release 0", "release -1", "cancel 1", "cancel 1000000000", "goto 10000 -10000"])
def test_what_is_at_its_limit_can_be_sent(line: str) -> None:
    assert impossible(request_from(line, MISSION), MISSION) == ""


def test_a_command_that_never_was_is_not_cancelled() -> None:
    said = "cancel: 0 is not a command id; ids count from 1"
    assert impossible(request_from("cancel 0", MISSION), MISSION).startswith(said)
    assert impossible(request_from("cancel 1", MISSION), MISSION) == ""


@given(
    st.sampled_from(["tolerance", "timeout", "release", "cancel"]),
    st.one_of(st.integers(-9, 99), st.floats(-1e3, 1e6, allow_nan=False)),
)
@settings(max_examples=examples(200), deadline=None)
def test_what_is_sent_is_not_rejected_for_its_arguments(word: str, value: float) -> None:
    with suppress(ValueError):
        request = request_from(f"{word} {value!r}", YARD)
        if not impossible(request, YARD):
            assert wrong_arguments(request.command(1, 1, 0, 0), rules_of(YARD).fence) == ""


NUMBERS = st.one_of(
    st.integers(), st.floats(), st.integers(-(2**70), 2**70), st.sampled_from(["1e400", "-1e-400", "9" * 400])
)


@given(
    st.sampled_from(["cancel", "release", "tolerance", "timeout", "goto 1", "goto 1 2 hold", "goto 1 2 timeout"]),
    NUMBERS,
    st.sampled_from(["", " s", " m", "cm", " d", " km"]),
)
@settings(max_examples=examples(300), deadline=None)
def test_what_is_sent_fits_into_the_log(word: str, number: object, unit: str) -> None:
    with suppress(ValueError):  # refused; nothing else may be raised
        request = request_from(f"{word} {number}{unit}", YARD)
        if not impossible(request, YARD):
            assert BY_KIND[Command].encode(request.command(1, 1, 0, 0))
