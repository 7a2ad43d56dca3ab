"""What the link did, as people and programs are told it."""

from __future__ import annotations

import json
from pathlib import Path

from tests.cli.flying import EASY, Program
from waypointctl.cli.tui.summary import link_lines
from waypointctl.log.messages import DeliveryOutcome, LinkRecord
from waypointctl.log.reader import open_log
from waypointctl.replay.link_summary import LinkDirectionSummary, LinkSummary


def test_a_line_for_each_way_on_which_there_is_something_to_tell() -> None:
    lost, twice = DeliveryOutcome.LOST, DeliveryOutcome.DUPLICATED
    up = LinkDirectionSummary({("command", lost): 1, ("heartbeat", lost): 2, ("ack", twice): 1})
    counts = {
        ("ack", lost): 1,
        ("bodyframe", DeliveryOutcome.NO_CONTACT): 2,
        ("telemetry", lost): 59,
        ("telemetry", DeliveryOutcome.QUEUE_FULL): 4,
        ("tele\x1bgram", lost): 1,
    }
    down = LinkDirectionSummary(counts, waited=12, longest_wait_ns=3_200_000_000)
    assert link_lines(LinkSummary(up, down)) == [
        "link up    3 lost (1 command, 2 heartbeats), 1 duplicated",
        "link down  61 lost; 4 dropped because the queue was full; 2 dropped because no contact was left "
        "(1 acknowledgement, 2 states, 1 tele\\u001bgram, 63 telemetry frames), 12 queued, "
        "for at most 3.20 s",
    ]
    assert link_lines(
        LinkSummary(LinkDirectionSummary(), LinkDirectionSummary(waited=1, longest_wait_ns=10_000_000))
    ) == ["link down  1 queued, for at most 10 ms"]
    assert link_lines(LinkSummary()) == []


def test_run_and_replay_tell_the_same_and_json_has_the_counts(yard: Path, program: Program) -> None:
    (yard / "lossy.yaml").write_text(EASY.replace("{delay: 0.5 s}", "{delay: 0.5 s, loss: 30 %}"))
    code, flown, _ = program("run", "lossy.yaml", "--out", "lossy.mcap")
    assert code == 0
    records = [m for m in open_log(yard / "lossy.mcap").messages() if isinstance(m, LinkRecord)]
    lost = [m for m in records if m.direction == "down" and m.outcome is DeliveryOutcome.LOST]
    told = [line for line in flown.splitlines() if line.startswith("link down  ")]
    assert len(told) == 1
    assert told[0].startswith(f"link down  {len(lost)} lost (")
    assert told[0] in program("replay", "lossy.mcap")[1].splitlines()
    link = json.loads(program("replay", "lossy.mcap", "--json")[1])["summary"]["link"]
    assert link["down"]["lost"] == sum(link["down"]["not_arrived"].values()) == len(lost) > 0
    assert link["up"]["lost"] == sum(m.direction == "up" for m in records)


def test_of_a_link_that_only_delays_nothing_is_told(yard: Path, program: Program) -> None:
    code, flown, _ = program("run", "easy.yaml", "--out", "easy.mcap")
    assert code == 0
    assert "link up" not in flown
    assert "link down" not in flown
    assert json.loads(program("replay", "easy.mcap", "--json")[1])["summary"]["link"]["up"]["lost"] == 0
