"""Contact plans in ION's terms."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from waypointctl.mission.contact_plan import read_contact_plan
from waypointctl.mission.text_file import read_jitter

RANGE = "a range +0 +1000000 1 2 1\n"

# What a node's configuration for several programs looks like; only ionadmin's part speaks of contacts.
WHOLE_CONFIGURATION = b"""\
## begin ionadmin
1 1 /home/ion/config
s
m horizon +0
# both ways
a contact +1 +3600 1 2 100000
a contact +1 +3600 2 1 12500 1.0
a contact -1 -1 19 19 0
a range   +1 +3600 1 2 1.25   # half a round trip
l contact
## end ionadmin
## begin bpadmin
1
a scheme ipn 'ipnfw' 'ipnadminep'
a contact is not read here
## end bpadmin
"""


def spans(source: str | bytes, way: tuple[int, int], **options: object) -> tuple[list[object], list[object]]:
    content = source if isinstance(source, bytes) else source.encode()
    passage, problems = read_contact_plan(content, "plan", way, **options)  # type: ignore[arg-type]
    assert problems == ()
    return tuple(  # type: ignore[return-value]
        [(each.begin_s, each.end_s, each.value) for each in part] for part in (passage.contacts, passage.ranges)
    )


def problems_of(source: str, way: tuple[int, int] = (1, 2), **options: object) -> list[str]:
    return [str(problem) for problem in read_contact_plan(source.encode(), "plan", way, **options)[1]]  # type: ignore[arg-type]


def test_a_nodes_whole_configuration_is_read() -> None:
    assert spans(WHOLE_CONFIGURATION, (1, 2)) == ([(1, 3600, 800_000)], [(1, 3600, 1.25)])
    assert spans(WHOLE_CONFIGURATION, (2, 1)) == ([(1, 3600, 100_000)], [(1, 3600, 1.25)])


def test_a_range_from_the_lower_node_holds_back_too_unless_the_way_back_has_its_own() -> None:
    contacts = "a contact +0 +10 1 2 1\na contact +0 +10 2 1 1\n"
    one = contacts + "a range +0 +10 1 2 3\n"
    assert [spans(one, way)[1] for way in ((1, 2), (2, 1))] == [[(0, 10, 3)], [(0, 10, 3)]]
    both = one + "a range +0 +10 2 1 4\n"
    assert [spans(both, way)[1] for way in ((1, 2), (2, 1))] == [[(0, 10, 3)], [(0, 10, 4)]]
    back = contacts + "a range +0 +10 2 1 4\n"
    assert spans(back, (2, 1))[1] == [(0, 10, 4)]
    assert problems_of(back) == [
        "plan:1:1: there is no range from node 1 to node 2 at +0 s of this contact; "
        "add one, or give the link a delay in the mission"
    ]


def test_an_at_line_moves_what_plus_counts_from() -> None:
    source = (
        "@ +100\na contact +0 +10 1 2 1\n@ +50\na contact +0 +10 1 2 1\n@ 2027/01/01-00:00:30\na range +0 +200 1 2 1\n"
    )
    contacts, ranges = spans(source, (1, 2), reference="2027/01/01-00:00:00")
    assert contacts == [(100, 110, 8), (150, 160, 8)]
    assert ranges == [(30, 230, 1)]


def test_absolute_times_count_from_the_missions_reference() -> None:
    source = "a contact 2027/03/01-00:00:00 2027/03/01-01:00:00 1 2 1\n" + RANGE
    assert spans(source, (1, 2), reference="2027/02/28-23:00:00")[0] == [(3600, 7200, 8)]


def test_what_is_over_by_mission_start_is_passed_over_and_what_is_under_way_holds_from_then() -> None:
    before = "a contact 2027/03/01-00:00:00 2027/03/01-01:00:00 1 2 1\na range 2027/03/01-00:00:00 +9999 1 2 3\n"
    after = "a contact 2027/03/01-02:00:00 2027/03/01-03:00:00 1 2 2\n"
    under_way = spans(before + after, (1, 2), reference="2027/03/01-00:30:00")
    assert under_way == ([(0, 1800, 8), (5400, 9000, 16)], [(0, 9999, 3)])
    over = spans(before + after, (1, 2), reference="2027/03/01-01:00:00")
    assert over == ([(3600, 7200, 16)], [(0, 9999, 3)])
    assert problems_of(before + after, reference="2027/03/01-03:00:00") == [
        "plan:1:1: this contact is over by mission start, as are all from node 1 to node 2"
    ]
    gone = "a range 2027/03/01-00:00:00 2027/03/01-00:30:00 1 2 3\na contact +0 +10 1 2 1\na range +0 +10 1 2 2\n"
    assert spans(gone, (1, 2), reference="2027/03/01-00:30:00") == ([(0, 10, 8)], [(0, 10, 2)])


def test_a_plan_with_dates_for_a_mission_without_one_has_one_place() -> None:
    source = "".join(
        f"a contact 2027/03/01-0{hour}:00:00 2027/03/01-0{hour}:30:00 {ways} 1\n"
        for hour, ways in enumerate(("5 6", "1 2", "2 1"))
    )
    for way in ((1, 2), (2, 1)):
        (problem,) = read_contact_plan(source.encode(), "plan", way)[1]
        assert (problem.line, problem.text.partition(" is an absolute time")[0]) == (1, "2027/03/01-00:00:00")


def test_contacts_are_put_in_the_order_of_time_and_ranges_may_follow_on_each_other() -> None:
    source = "a contact +50 +60 1 2 2\na contact +0 +50 1 2 1\na range +20 +60 1 2 2\na range +0 +20 1 2 1\n"
    assert spans(source, (1, 2)) == ([(0, 50, 8), (50, 60, 16)], [(0, 20, 1), (20, 60, 2)])


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        (
            "a contact +0 +10 1 2",
            "1:1: has 4 values; expected are start time, stop time, source node, destination node, rate in bytes/s",
        ),
        (
            "a range +0 +10 1 2 1 1",
            "1:1: has 6 values; expected are start time, stop time, one node, other node, light time in s",
        ),
        ("a contact 1 +10 1 2 1", "1:11: '1' is not a time: write +seconds"),
        (
            "a contact 0 +10 1 2 1",
            "1:1: this contact is hypothetical (a time is 0): it has no time; mission start is +0",
        ),
        ("a contact +x +10 1 2 1", "1:11: '+x' is not a number: time"),
        ("a contact +nan +10 1 2 1", "1:11: +nan is not from 0 to 1e+09: time"),
        ("a contact +10 +10 1 2 1", "1:15: +10 is not after +10"),
        ("a contact +0 +10 one 2 1", "1:18: 'one' is not a node number"),
        ("a contact +0 +10 1 2 0", "1:22: 0 is not from 1 to 1e+09: rate in bytes/s"),
        ("a range +0 +10 1 2 -1", "1:20: -1 is not from 0 to 1e+09: light time in s"),
        ("a contact +0 +10 1 2 1 0.8", "1:24: only a contact that is certain can be flown: leave the confidence out"),
        ("d contact +0 1 2", "1:1: 'd contact' would change the plan; write the plan as it is to be, with 'a contact'"),
        (
            "c contact +0 1 2 5",
            "1:1: 'c contact' would change the plan; write the plan as it is to be, with 'a contact'",
        ),
        ("@", "1:1: '@' needs a time"),
        (
            "a contact 2027/01/01-00:00:00 +10 1 2 1",
            "1:11: 2027/01/01-00:00:00 is an absolute time, and the mission has no date; write +seconds after mission "
            "start, or give the contact_plan in the mission the date of its start as 'reference'",
        ),
        (
            "a contact +0 +10 1 2 1\na contact +5 +15 1 2 1\na range +0 +10 1 2 1\na range +1 +10 1 2 1",
            "2:1: this contact overlaps that of line 1\nplan:4:1: this range overlaps that of line 3",
        ),
        (
            "a contact +0 +10 1 2 1\na range +0 +5 1 2 1\na range +6 +10 1 2 1",
            "1:1: there is no range from node 1 to node 2 at +5 s of this contact; add one, or give the link a delay "
            "in the mission",
        ),
    ],
)
def test_what_is_wrong_is_told_with_its_place(line: str, problem: str) -> None:
    assert "\n".join(problems_of(line)) == f"plan:{problem}"


def test_a_plan_without_the_contact_says_which_it_has() -> None:
    assert problems_of("a contact +0 +10 1 3 1\na contact +0 +10 3 2 1") == [
        "plan:1:1: has no contact from node 1 to node 2; its contacts are from 1 to 3, from 3 to 2"
    ]
    assert problems_of("# nothing") == ["plan:1:1: has no contact from node 1 to node 2; its contacts are none at all"]


@pytest.mark.parametrize(
    "line",
    [
        "a contact +60 +600 5 7 10000 0.4",
        "a contact 0 0 3 4 0 0.0",
        "a contact 2027/03/01-00:00:00 2027/03/01-01:00:00 1 3 1",
        "a contact +10 +5 3 2 0",
        "a contact +0 +10 ipn:1 7 1",
        "a contact 0 0 1 2 0 0.0",
        "a contact +1 0 1 2 0",
        "a contact -1 -1 1 1 0",
        "a range +0 +5 1 9 nan",
        "a range 2027/03/01-00:00:00 +5 8 9 1",
        "c contact +0 5 7 100",
        "d contact * 2 1",
        "d range +0 1 7",
        "b contact",
        "b range",
        "i contact +0 1 2",
        "l range",
        "m horizon +0",
        "m utcdelta 3",
        "^ 2",
        "# a contact",
    ],
)
def test_what_does_not_say_when_the_two_nodes_can_talk_is_passed_over(line: str) -> None:
    needed = "a contact +0 +10 1 2 1\n" + RANGE
    expected = spans(needed, (1, 2))
    assert spans(f"{line}\n{needed}", (1, 2)) == expected
    assert spans(f"{needed}{line}\n", (1, 2)) == expected


@pytest.mark.parametrize(
    ("source", "kind"),
    [
        (b'{"contacts": [{"contact": 0}]}', "is JSON (a contact plan of HDTN)"),
        (b"[1]", "is JSON"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n", "is a Git LFS pointer, not the file"),
        (b"PK\x03\x04" + bytes(9), "is a ZIP archive"),
        (b"\xff\xfea\0 \0", "is not UTF-8 text but UTF-16"),
        (b"a contact\0", "is a binary file, not text"),
        (b"<!DOCTYPE html><html></html>", "is an HTML page"),
        (b"<?xml version='1.0'?><!-- x --><gpx/>", "is a GPX file"),
    ],
)
def test_another_kind_of_file_is_named_in_one_problem(source: bytes, kind: str) -> None:
    (plan,) = read_contact_plan(source, "plan", (1, 2))[1]
    assert str(plan).startswith(f"plan: {kind}")
    assert re.search(r"(, not|; expected is) a contact plan in ION's terms \('a contact \.\.\.'\)$", str(plan))
    (jitter,) = read_jitter(source, "j")[1]
    assert str(jitter).startswith(f"j: {kind}")


def test_without_need_of_ranges_there_may_be_none() -> None:
    assert spans("a contact +0 +10 1 2 1", (1, 2), needs_ranges=False) == ([(0, 10, 8)], [])


def test_every_problem_is_told() -> None:
    assert problems_of("a contact +0 +10 a b -1\nd range +0 1 2") == [
        "plan:1:18: 'a' is not a node number",
        "plan:1:20: 'b' is not a node number",
        "plan:1:22: -1 is not from 1 to 1e+09: rate in bytes/s",
        "plan:2:1: 'd range' would change the plan; write the plan as it is to be, with 'a range'",
    ]


LINES = st.lists(
    st.sampled_from([*WHOLE_CONFIGURATION.split(b"\n"), b"a contact", b"@ +1", b"\xff", b"a range +0 +1 1 2"])
)


@given(LINES, st.binary(max_size=20))
def test_any_bytes_are_read_or_refused_with_their_place(lines: list[bytes], tail: bytes) -> None:
    source = b"\n".join(lines) + tail
    for problem in read_contact_plan(source, "plan", (1, 2))[1] + read_jitter(source, "plan")[1]:
        assert 0 <= problem.line <= source.count(b"\n") + 1
        assert problem.text


def test_jitter_is_one_number_a_line() -> None:
    assert read_jitter(b"# s\r\n 0.01 # first\n\n-2e-3\n5\n", "j") == ((0.01, -0.002, 5.0), ())


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        (b"0.1\n0,2", "j:2:1: '0,2' is not a number of seconds"),
        (b"0.1\n1_0", "j:2:1: '1_0' is not a number of seconds"),
        (b"0.1 0.2", "j:1:5: '0.2' follows the number; write one number of seconds a line"),
        (b"nan", "j:1:1: nan is not between -86400 and 86400 s"),
        (b"  1e6", "j:1:3: 1e6 is not between -86400 and 86400 s"),
        (b"# none", "j:1:1: holds no number; a file of jitter has one number of seconds a line"),
        (b"0.1\n\xff", "j:2:1: is not UTF-8 text: byte 0xff"),
    ],
)
def test_wrong_jitter_is_told_with_its_place(source: bytes, problem: str) -> None:
    assert [str(each) for each in read_jitter(source, "j")[1]] == [problem]


def test_a_missing_date_is_told_once() -> None:
    dated = "a contact 2027/03/01-00:30:00 2027/03/01-00:31:00 1 2 1\na range 2027/03/01-00:30:00 +60 1 2 1"
    (problem,) = problems_of(dated)
    assert problem.startswith("plan:1:11: 2027/03/01-00:30:00 is an absolute time, and the mission has no date")
    assert problems_of(dated + "\na contact +0 +1 x 2 1")[1:] == ["plan:3:17: 'x' is not a node number"]


def test_jitter_that_makes_the_delay_negative_is_refused() -> None:
    assert read_jitter(b"0.5\n-1\n", "j", 1.0) == ((0.5, -1.0), ())
    (problem,) = read_jitter(b"0.5\n -5\n", "j", 1.0)[1]
    assert str(problem).startswith("j:2:2: -5 s takes more off than the delay of 1 s")
