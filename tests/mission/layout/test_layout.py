from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.mission.drawn import missions
from waypointctl.errors import MissionError
from waypointctl.mission.files import dump_mission, parse_mission
from waypointctl.mission.layout.layout import laid_out
from waypointctl.mission.mission import Mission

MISSIONS = Path(__file__).parents[3] / "missions"
HEAD = "name: n\npolicy: p\n"
PLACES = "waypoints:\n  - [1, 2]\n"


def layout(text: str) -> str:
    """Lay a mission out; again comes to the same, and both to what was meant."""
    once = laid_out(text.encode(), "m.yaml")
    assert laid_out(once, "m.yaml") == once
    assert parse_mission(once, "m.yaml") == parse_mission(text.encode(), "m.yaml")
    return once.decode()


@pytest.mark.parametrize("path", sorted(MISSIONS.glob("*.yaml")), ids=lambda path: path.stem)
def test_the_shipped_missions_are_laid_out(path: Path) -> None:
    assert laid_out(path.read_bytes(), str(path)) == path.read_bytes()


def test_keys_come_in_the_models_order_under_whatever_name() -> None:
    text = "waypoints:\n  - {timeout: 3 s, position: [1 m, 2 m], name: a}\nseed: 3\npolicy: p\n'name': n\n"
    assert layout(text) == (
        "'name': n\nseed: 3\npolicy: p\n\nwaypoints:\n  - {name: a, position: [1 m, 2 m], timeout: 3 s}\n"
    )


def test_the_keys_that_both_ways_of_a_link_share_are_ordered_too() -> None:
    text = HEAD + PLACES + "link: {loss: {r: 0.5, p: 0.1}, jitter: 10 ms, delay: 1 s, preset: iss}\n"
    assert layout(text).endswith("\nlink:\n  preset: iss\n  delay: 1 s\n  jitter: 10 ms\n  loss: {p: 0.1, r: 0.5}\n")


def test_a_mapping_with_a_mapping_in_it_takes_a_line_a_key() -> None:
    text = HEAD + PLACES + "onboard: {geofence: {keep_out: [{radius: 2 m, center: [1 m, 2 m]}]}, slip: 1 m}\n"
    assert layout(text).endswith(
        "onboard:\n  slip: 1 m\n  geofence:\n    keep_out:\n      - {center: [1 m, 2 m], radius: 2 m}\n"
    )


def test_what_is_too_long_for_a_line_takes_several() -> None:
    rest = "position: [1 m, 2 m], tolerance: 0.5 m, timeout: 1234.5678 s, hold: 1 s"
    text = f"{HEAD}waypoints: [{{name: a long name that takes its room, {rest}}}]\n"
    assert "\n  - {name: " in layout(text)
    text = text.replace("hold", "acceptance: radius, hold")
    assert "\n  - name: " in layout(text)
    assert "\n    position: [1 m, 2 m]\n" in layout(text)


@pytest.mark.parametrize(
    ("given_text", "expected"),
    [
        ("# top\n\npolicy: p # who\n# lead\nname: n\n" + PLACES, "# top\n\n# lead\nname: n\npolicy: p # who\n"),
        (HEAD + "waypoints: # all\n- [1, # x\n   2]\n", "waypoints: # all\n  -\n    - 1 # x\n    - 2\n"),
        (HEAD + "waypoints:\n-  # behind\n   name: a\n   position: [1 m, 2 m]\n", "  # behind\n  - {name: a, pos"),
        (HEAD + PLACES + "  # - [3, 4] not now\nseed: 1\n", "  - [1, 2]\n  # - [3, 4] not now\n"),
        (HEAD + PLACES + "# the end\n", "  - [1, 2]\n# the end\n"),
        (HEAD + "waypoints:\n- [1, 2]\n# the end\n", "  - [1, 2]\n# the end\n"),
        (
            HEAD + PLACES + "link:\n  jitter: 1 ms # j\n  # d\n  delay: 1 s\n",
            "link:\n  # d\n  delay: 1 s\n  jitter: 1 ms # j\n",
        ),
        (
            HEAD + PLACES + "description: | # why\n      a\n       b # no comment\n",
            "description: | # why\n  a\n   b # no comment\n",
        ),
        (
            HEAD + PLACES + "expect: {reached: all, # one\n  max_time: 3 s} # two\n",
            "expect: # two\n  reached: all # one\n",
        ),
        (HEAD + PLACES + "link: {delay: 1 s} # eol\n", "link: # eol\n  delay: 1 s\n"),
    ],
)
def test_comments_stay_with_what_they_are_about(given_text: str, expected: str) -> None:
    assert expected in layout(given_text)


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
        "a, b [c] {d}",
        "'-1: x'",
        '""',
    ],
)
def test_texts_say_the_same_in_any_style(description: str) -> None:
    layout(f"{HEAD}{PLACES}description: {description}\n")


def test_blank_lines_stay_but_one_at_a_time() -> None:
    text = "name: n\n\n\npolicy: p\nwaypoints:\n\n  - [1, 2]\n\n\n  - [3, 4]\nexpect: {max_time: 3 s}\n"
    assert layout(text) == (
        "name: n\n\npolicy: p\n\nwaypoints:\n  - [1, 2]\n\n  - [3, 4]\n\nexpect:\n  max_time: 3 s\n"
    )


@pytest.mark.parametrize("head", ["\ufeff", "---\n", "%YAML 1.2\n---\n"])
def test_what_yaml_does_not_need_is_left_out(head: str) -> None:
    assert layout(head + HEAD + PLACES) == f"{HEAD}\n{PLACES}"


def test_line_ends_of_other_systems_become_line_feeds() -> None:
    assert layout((HEAD + PLACES).replace("\n", "\r\n")) == f"{HEAD}\n{PLACES}"


def test_a_mission_in_braces_is_written_out() -> None:
    assert layout("{waypoints: [[1, 2]], policy: p, name: n}\n") == f"{HEAD}\n{PLACES}"


def test_a_file_with_mistakes_is_refused_with_all_of_them() -> None:
    with pytest.raises(MissionError, match=r"2 problems\nm\.yaml:1:1: nam: unknown key(.|\n)*m\.yaml:3:12"):
        laid_out(b"nam: n\npolicy: p\nwaypoints: 3\nname: x\n", "m.yaml")


@settings(deadline=None, max_examples=40)
@given(missions())
def test_any_mission_reads_back_as_the_same(mission: Mission) -> None:
    once = laid_out(dump_mission(mission).encode(), "dump")
    assert parse_mission(once, "laid out") == mission
    assert laid_out(once, "again") == once


SNIPPETS = ["# c\n", " # c\n", "\n", "    # in\n", "  ", "#x", " ", "\n\n"]


@settings(deadline=None, max_examples=60)
@given(st.data())
def test_comments_anywhere_are_kept_or_the_file_is_left_alone(data: st.DataObject) -> None:
    text = data.draw(st.sampled_from([path.read_text() for path in sorted(MISSIONS.glob("*.yaml"))]))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text)))
        text = text[:at] + data.draw(st.sampled_from(SNIPPETS)) + text[at:]
    try:
        mission = parse_mission(text.encode(), "m.yaml")
    except MissionError:
        return
    once = laid_out(text.encode(), "m.yaml")
    assert parse_mission(once, "laid out") == mission
    assert laid_out(once, "again") == once
