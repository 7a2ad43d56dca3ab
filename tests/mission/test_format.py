from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.mission.drawn import missions
from waypointctl.errors import MissionError
from waypointctl.mission.files import dump_mission, parse_mission
from waypointctl.mission.format import formatted
from waypointctl.mission.mission import Mission

REPOSITORY = Path(__file__).parents[2]
SHIPPED = sorted([*REPOSITORY.glob("missions/*.yaml"), REPOSITORY / "waypointctl/cli/starter/mission.yaml"])
HEAD = "name: n\npolicy: p\n"
PLACES = "waypoints:\n  - [1, 2]\n"


def layout(text: str) -> str:
    """Format a mission; a second time changes nothing, and neither changes the mission."""
    once = formatted(text.encode(), "m.yaml")
    assert formatted(once, "m.yaml") == once
    assert parse_mission(once, "m.yaml") == parse_mission(text.encode(), "m.yaml")
    return once.decode()


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_the_shipped_missions_are_formatted(path: Path) -> None:
    assert formatted(path.read_bytes(), str(path)) == path.read_bytes()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "waypoints:\n  - {timeout: 3 s, position: [1 m, 2 m], name: a}\nseed: 3\npolicy: p\n'name': n\n",
            "'name': n\nseed: 3\npolicy: p\nwaypoints:\n  - {name: a, position: [1 m, 2 m], timeout: 3 s}\n",
        ),
        (
            HEAD + PLACES + "link: {loss: {r: 0.5, p: 0.1}, jitter: 10 ms, delay: 1 s, preset: iss}\n",
            HEAD + PLACES + "link: {preset: iss, delay: 1 s, jitter: 10 ms, loss: {p: 0.1, r: 0.5}}\n",
        ),
        (
            HEAD + "waypoints:\n- hold: 1 s\n  # x\n  position:\n  - 1 m\n  - 2 m\n  name: a\n- [3, 4]\n",
            HEAD
            + "waypoints:\n  - name: a\n  # x\n    position:\n      - 1 m\n      - 2 m\n    hold: 1 s\n  - [3, 4]\n",
        ),
        ("{waypoints: [[1, 2]], policy: p, name: n}\n", "{name: n, policy: p, waypoints: [[1, 2]]}\n"),
    ],
)
def test_keys_come_in_the_models_order_under_whatever_name(text: str, expected: str) -> None:
    assert layout(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f"# top\n\npolicy: p # p\n# lead\nname: n\n{PLACES}", f"# top\n\n# lead\nname: n\npolicy: p # p\n{PLACES}"),
        (
            HEAD + PLACES + "  # - [3, 4] not now\nseed: 1\n",
            f"name: n\nseed: 1\npolicy: p\n{PLACES}  # - [3, 4] not now\n",
        ),
        (PLACES + "# n\nname: n\npolicy: p\n\n# the end\n", f"# n\n{HEAD}{PLACES}\n# the end\n"),
        (
            HEAD + PLACES + "link:\n  jitter: 1 ms # j\n  # d\n  delay: 1 s\nexpect: {}\n",
            HEAD + PLACES + "link:\n  # d\n  delay: 1 s\n  jitter: 1 ms # j\nexpect: {}\n",
        ),
        (HEAD + PLACES + "link: {delay: 1 s} # eol\n", HEAD + PLACES + "link: {delay: 1 s} # eol\n"),
        ("policy: p\nname: n # n\nwaypoints: [[1, 2]]", "name: n # n\npolicy: p\nwaypoints: [[1, 2]]\n"),
    ],
)
def test_comments_stay_with_what_they_are_about(text: str, expected: str) -> None:
    assert layout(text) == expected


@pytest.mark.parametrize(
    "description",
    [
        '"a # b: [c]"',
        "'it''s'",
        "two\n  lines\n\n  and more",
        '"tab\\tand \\u00e9 \\x07"',
        '"folded\n  text"',
        "|\n\n    blank first\n",
        ">-\n  folded\n  text\n\n    kept\n  end",
        "|+\n  keeps its end\n\n",
        "|2\n    indented first\n  then not\n",
        "| # why\n      a\n       b # no comment\n",
        "a, b [c] {d}",
        "'-1: x'",
        '""',
        "~",
        "1e3",
    ],
)
def test_texts_say_the_same_in_any_style(description: str) -> None:
    text = f"name: n\ndescription: {description}\npolicy: p\n{PLACES}"
    try:
        parse_mission(text.encode(), "m.yaml")
    except MissionError:
        return  # no text: null or a number
    layout(text)


def test_blank_lines_and_numbers_stay_as_they_are_written() -> None:
    text = "name: n\n\n\npolicy: p\nwaypoints:\n\n  - [1.50, +2]\n\n\n  - [0x10, 3.]\nexpect: {max_time: 3e0 s}\n"
    assert layout(text) == text


def test_line_ends_and_byte_order_marks_of_other_systems_go() -> None:
    assert layout("\ufeff---\n" + (HEAD + PLACES).replace("\n", "\r\n")) == HEAD + PLACES


@pytest.mark.parametrize("places", ["[[1, # east\n  2]]", "\n  - {position: [1 m, 2 m], # there\n     name: a}"])
def test_a_comment_within_braces_is_refused(places: str) -> None:
    with pytest.raises(MissionError, match="would lose a comment"):
        formatted(f"{HEAD}waypoints: {places}\n".encode(), "m.yaml")


def test_a_file_with_errors_is_refused_with_all_of_them() -> None:
    with pytest.raises(MissionError, match=r"2 problems\nm\.yaml:1:1: nam: unknown key(.|\n)*m\.yaml:3:12"):
        formatted(b"nam: n\npolicy: p\nwaypoints: 3\nname: x\n", "m.yaml")


@settings(deadline=None, max_examples=12)
@given(missions())
def test_any_mission_reads_back_as_the_same(mission: Mission) -> None:
    assert parse_mission(layout(dump_mission(mission)).encode(), "formatted") == mission


SNIPPETS = ["# c\n", " # c\n", "\n", "    # in\n", "  ", "#x", " ", "\n\n"]
SMALL = (
    "# top\n\npolicy: p\nname: n # n\n\nwaypoints:\n  # first\n  - hold: 1 s\n    position: [1 m, 2 m]\n"
    "  - {tolerance: 1 m, position: [3 m, 4 m]}\n\nlink:\n  up:\n    jitter: 1 ms\n    delay: 1 s\n  # way back\n"
    "  down: {delay: 2 s}\n# end\n"
)


@settings(deadline=None, max_examples=40)
@given(st.data())
def test_comments_anywhere_are_kept_or_the_file_is_refused(data: st.DataObject) -> None:
    text = SMALL
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text)))
        text = text[:at] + data.draw(st.sampled_from(SNIPPETS)) + text[at:]
    try:
        mission = parse_mission(text.encode(), "m.yaml")
        once = formatted(text.encode(), "m.yaml")
    except MissionError:
        return
    assert parse_mission(once, "formatted") == mission
    assert once.count(b"#") == text.count("#")
    assert formatted(once, "again") == once
