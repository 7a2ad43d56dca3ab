"""What a mission may write of its link, and what is said of mistakes in it and in the files that it refers to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from waypointctl.errors import MissionError
from waypointctl.mission.files import dump_mission, load_mission, parse_mission
from waypointctl.mission.link import Bursts, ContactPlan, DelayAt, Link, LinkDirection, Window
from waypointctl.mission.presets import PRESETS

HEAD = "name: n\npolicy: p\nwaypoints: [[7, 12]]\n"
PLAN = b"a contact +0 +60 1 2 1000\na contact +0 +60 2 1 1000\na range +0 +60 1 2 1\n"
FILES = {"plan.ionrc": PLAN, "j/rtt.txt": b"0.01\n-0.02\n"}


def link_of(text: str) -> Link:
    return parse_mission((HEAD + text).encode(), "m.yaml", FILES).link


def refusal(text: str) -> str:
    with pytest.raises(MissionError) as caught:
        parse_mission((HEAD + text).encode(), "m.yaml", FILES)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "way"),
    [
        ("{jitter_distribution: normal, jitter: 2 s}", {"jitter_distribution": "normal", "jitter_s": 2.0}),
        ("{loss: 0.01, duplicate: 1 %}", {"loss": 0.01, "duplicate": 0.01}),
        ("{loss: {p: 1 %, r: 0.3}}", {"loss": Bursts(p=0.01, r=0.3)}),
        (
            "{loss: {p: 0.1, r: 1, one_minus_h: 50 %, one_minus_k: 0.1 %}}",
            {"loss": Bursts(p=0.1, r=1, one_minus_h=0.5, one_minus_k=0.001)},
        ),
        ("{rate: 64 kbit/s, queue: 2 KiB}", {"rate_bps": 64e3, "queue_bytes": 2048}),
        (
            "{rate_bps: 9600, queue: 1.5 MB, keep_order: false}",
            {"rate_bps": 9600, "queue_bytes": 1.5e6, "keep_order": False},
        ),
        (
            "{delay_table: [{at: 0 s, delay: 1.28 s}, {at_s: 60, delay_s: 1.3}], jitter: 1280 ms}",
            {"delay_table": (DelayAt(at_s=0, delay_s=1.28), DelayAt(at_s=60, delay_s=1.3)), "jitter_s": 1.28},
        ),
        (
            "{windows: [{from: 0 s, to: 8 min}, {from_s: 480, to_s: 500}], windows_period: 90 min}",
            {"windows": (Window(from_s=0, to_s=480), Window(from_s=480, to_s=500)), "windows_period_s": 5400},
        ),
        ("{delay: 20 ms, jitter_file: j/rtt.txt}", {"delay_s": 0.02, "jitter_file": "j/rtt.txt"}),
    ],
)
def test_a_way_is_written_with_units_or_without(text: str, way: dict[str, Any]) -> None:
    assert link_of(f"link: {text}") == Link(up=LinkDirection(**way), down=LinkDirection(**way))


def test_a_contact_plan_for_both_ways_leads_back_on_the_way_down() -> None:
    link = link_of("link: {contact_plan: {file: plan.ionrc, from_node: 1, to_node: 2}}")
    assert [each.contact_plan and each.contact_plan.way for each in (link.up, link.down)] == [(1, 2), (2, 1)]
    up = LinkDirection(contact_plan=ContactPlan(file="plan.ionrc", from_node=1, to_node=2))
    assert link_of("link: {up: {contact_plan: {file: plan.ionrc, from_node: 1, to_node: 2}}}") == Link(up=up)


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_is_the_same_both_ways(name: str) -> None:
    assert link_of(f"link: {{preset: {name}}}") == Link.model_validate(
        {"preset": name, "up": PRESETS[name], "down": PRESETS[name]}
    )


def test_presets_are_in_the_order_of_their_distance() -> None:
    delays = {name: link_of(f"link: {{preset: {name}}}").up.delay_s for name in PRESETS}
    assert (
        delays["lan"] < delays["moon"] < delays["moon-relay"] < delays["iss"] < delays["mars-near"] < delays["mars-far"]
    )
    light_km_s = 299_792.458
    assert delays["moon"] == pytest.approx(384_400 / light_km_s, abs=1e-3)
    assert delays["mars-near"] == pytest.approx(54.6e6 / light_km_s, abs=1)
    assert delays["mars-far"] == pytest.approx(401e6 / light_km_s, abs=1)


@pytest.mark.parametrize(
    ("text", "up", "down"),
    [
        ("preset: iss, delay: 4 s", {"delay_s": 4, "jitter_s": 0.5}, {"delay_s": 4, "jitter_s": 0.5}),
        ("preset: iss, jitter_distribution: normal", {"delay_s": 3.5, "jitter_distribution": "normal"}, None),
        ("preset: moon, loss: 2 %", {"delay_s": 1.282, "loss": 0.02}, None),
        ("preset: lan, up: {rate: 1 kbit/s}", {**PRESETS["lan"], "rate_bps": 1000}, PRESETS["lan"]),
        (
            "preset: moon, down: {delay_table: [{at: 0 s, delay: 3 s}]}",
            PRESETS["moon"],
            {"delay_table": [{"at_s": 0, "delay_s": 3}]},
        ),
        (
            "preset: lan, up: {contact_plan: {file: plan.ionrc, from_node: 1, to_node: 2}, jitter_s: 0}",
            {"contact_plan": {"file": "plan.ionrc", "from_node": 1, "to_node": 2}},
            PRESETS["lan"],
        ),
    ],
)
def test_what_is_written_beside_a_preset_goes_first(text: str, up: dict[str, Any], down: dict[str, Any] | None) -> None:
    name = text.split(",")[0].removeprefix("preset: ")
    expected = Link.model_validate({"up": up, "down": up if down is None else down})
    assert link_of(f"link: {{{text}}}") == expected.model_copy(update={"preset": name})


@pytest.mark.parametrize(
    "text",
    [
        "preset: lan, loss: {p: 0.1, r: 0.2}",
        "preset: iss, jitter_s: 0",
        "delay_table: [{at: 0 s, delay: 1 s}], windows: [{from: 0 s, to: 1 s}]",
        "contact_plan: {file: plan.ionrc, from_node: 1, to_node: 2}, jitter_file: j/rtt.txt",
    ],
)
def test_any_link_is_dumped_and_read_back(text: str) -> None:
    mission = parse_mission((HEAD + f"link: {{{text}}}").encode(), "m.yaml", FILES)
    assert parse_mission(dump_mission(mission).encode(), "dump", FILES) == mission


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            "{preset: mon}",
            "4:16: link.preset: expected one of 'moon', 'moon-relay', 'mars-near', 'mars-far', 'iss' or 'lan'; got 'mon'; "  # noqa: E501
            "did you mean 'moon'?",
        ),
        ("{loss: 2}", "4:14: link.loss: must be at most 1; got 2"),
        (
            "{loss: some}",
            "4:14: link.loss: 'some' is not a probability; write a number from 0 to 1, or a share such as '2 %'",
        ),
        ("{loss: 120 %}", "4:14: link.loss: must be at most 100 %; got 120 %"),
        ("{loss: {p: 0.1}}", "4:14: link.loss: required key 'r' is missing"),
        (
            "{up: {loss: {p: 0.1, r: 0, h: 1}}}",
            "4:34: link.up.loss.h: unknown key; allowed are p, r, one_minus_h, one_minus_k",
        ),
        ("{rate: 64}", "4:14: link.rate: 64 has no unit; write 'rate: 64 bit/s' or 'rate_bps: 64'"),
        ("{rate: 1 kbps}", "4:14: link.rate: '1 kbps' has the unit 'kbps'; allowed are bit/s, kbit/s, Mbit/s, Gbit/s"),
        ("{rate_bps: 0}", "4:18: link.rate_bps: must be at least 1 bit/s; got 0 bit/s"),
        ("{queue: 1 GB}", "4:15: link.queue: '1 GB' has the unit 'GB'; allowed are B, kB, KiB, MB, MiB"),
        ("{windows: []}", "4:17: link.windows: has 0 entries; at least 1 are needed"),
        ("{windows: [{from: 5 s, to: 5 s}]}", "4:34: link.windows[0].to: 5 s is not after 5 s"),
        (
            "{windows: [{from: 0 s, to: 5 s}, {from: 4 s, to: 9 s}]}",
            "4:47: link.windows[1].from: 4 s is before the 5 s at which the window before ends",
        ),
        (
            "{windows: [{from: 0 s, to: 5 s}], windows_period: 4 s}",
            "4:57: link.windows_period: 4 s ends before the last window, which ends at 5 s",
        ),
        ("{windows_period: 4 s}", "4:24: link.windows_period: needs 'windows'"),
        (
            "{delay: 1 s, delay_table: [{at: 0 s, delay: 1 s}]}",
            "4:33: link.delay_table: 'delay_table' and 'delay' are both given: keep one",
        ),
        (
            "{delay_table: [{at: 3 s, delay: 1 s}, {at: 3 s, delay: 1 s}]}",
            "4:50: link.delay_table[1].at: 3 s is not after the 3 s of the row before",
        ),
        (
            "{delay_table: [{at: 3 s, delay: 1 s}, {at: 4 s, delay: 2 s}], jitter: 1.5 s}",
            "4:77: link.jitter: 1.5 s is more than the delay of 1 s",
        ),
        (
            "{delay: 1 s, jitter: 1 s, jitter_file: j/rtt.txt}",
            "4:46: link.jitter_file: 'jitter_file' and 'jitter' are both given: keep one",
        ),
        (
            "{contact_plan: {file: plan.ionrc, from_node: 1, to_node: 2}, rate: 1 bit/s}",
            "4:74: link.rate: 'rate' and 'contact_plan' are both given: keep one",
        ),
        (
            "{contact_plan: {file: /etc/plan, from_node: 1, to_node: 2}}",
            "4:29: link.contact_plan.file: '/etc/plan' is not a file beside the mission or below its folder: "
            "write 'plan.ionrc' or 'a/b'",
        ),
        (
            "{contact_plan: {file: plan.ionrc, from_node: 1, to_node: 2, reference: today}}",
            "4:78: link.contact_plan.reference: 'today' is not a moment of the form 2027/01/31-12:00:00",
        ),
        ("{jitter_file: no.txt}", "4:21: link.jitter_file: no.txt does not exist"),
    ],
)
def test_a_wrong_link_says_what_where_and_what_is_allowed(text: str, problem: str) -> None:
    assert refusal(f"link: {text}") == f"m.yaml:{problem}"


def test_mistakes_in_the_mission_and_in_its_files_are_told_together(tmp_path: Path) -> None:
    (tmp_path / "plans").mkdir()
    (tmp_path / "plans" / "p.ionrc").write_text("a contact +0 +60 1 2 fast\n")
    (tmp_path / "j.txt").write_text("# seconds\n0.1\nmany\n")
    path = tmp_path / "m.yaml"
    path.write_text(
        HEAD
        + "sead: 4\nlink:\n  up: {jitter_file: j.txt, contact_plan: {file: plans/p.ionrc, from_node: 1, to_node: 2}}\n"
        + "  down: {jitter_file: gone.txt}\n"
    )
    with pytest.raises(MissionError) as caught:
        load_mission(path)
    assert str(caught.value).splitlines() == [
        f"{path}: 4 problems",
        f"{path}:4:1: sead: unknown key; did you mean 'seed'?",
        f"{path}:7:23: link.down.jitter_file: {tmp_path / 'gone.txt'} does not exist",
        f"{tmp_path / 'j.txt'}:3:1: 'many' is not a number of seconds",
        f"{tmp_path / 'plans' / 'p.ionrc'}:1:22: 'fast' is not a number: rate in bytes/s",
    ]


def test_one_cause_in_a_file_is_one_problem_however_many_lines_have_it(tmp_path: Path) -> None:
    lines = [f"a contact +{at} +{at + 1} {ways} 9 0.5\n" for at in range(43) for ways in ("1 2", "2 1")]
    (tmp_path / "p.ionrc").write_text("".join(lines))
    path = tmp_path / "m.yaml"
    path.write_text(HEAD + "link: {delay: 1 s, contact_plan: {file: p.ionrc, from_node: 1, to_node: 2}}\n")
    with pytest.raises(MissionError) as caught:
        load_mission(path)
    assert str(caught.value) == (
        f"{tmp_path / 'p.ionrc'}:1:23: only a contact that is certain can be flown: leave the confidence out "
        "(and 85 more of the kind, the last in line 86)"
    )


def test_a_mission_is_read_with_its_files(tmp_path: Path) -> None:
    (tmp_path / "j").mkdir()
    for name, content in FILES.items():
        (tmp_path / name).write_bytes(content)
    path = tmp_path / "m.yaml"
    link = "link: {contact_plan: {file: plan.ionrc, from_node: 1, to_node: 2}, jitter_file: j/rtt.txt}"
    path.write_text(HEAD + link)
    file = load_mission(path)
    assert file.files == file.mission.files == FILES
    assert file.mission == parse_mission(file.source, "log", FILES)
    assert file.mission.model_copy(update={"seed": 5}).files == FILES


def test_only_the_files_that_a_mission_refers_to_are_taken() -> None:
    assert parse_mission((HEAD + "link: {delay: 20 ms, jitter_file: j/rtt.txt}").encode(), "m", FILES).files == {
        "j/rtt.txt": FILES["j/rtt.txt"]
    }


@pytest.mark.parametrize(
    ("delay", "least"),
    [
        ("delay: 10 ms, jitter_file: j/rtt.txt", "0.01"),
        ("delay_table: [{at: 0 s, delay: 1 s}, {at: 9 s, delay: 15 ms}], jitter_file: j/rtt.txt", "0.015"),
        ("up: {delay: 1 s, jitter_file: j/rtt.txt}, down: {delay: 19 ms, jitter_file: j/rtt.txt}", "0.019"),
    ],
)
def test_measured_jitter_may_not_be_more_than_the_shortest_delay(delay: str, least: str) -> None:
    with pytest.raises(MissionError, match=rf"rtt.txt:2:1: -0.02 s takes more off than the delay of {least} s"):
        parse_mission((HEAD + f"link: {{{delay}}}").encode(), "m", FILES)
