"""Which stage may follow which, and which report of a stage counts."""

from __future__ import annotations

import pytest

from waypointctl.flight.command_life import NEVER_STARTED, NOT_STARTED, ONBOARD, StageReport, may_follow
from waypointctl.log.messages import FINAL_STAGES, Stage

ON_ARRIVAL = {Stage.REJECTED, Stage.CANCELLED, Stage.EXPIRED, Stage.SKIPPED}
MAY_FOLLOW = {
    Stage.RECEIVED: ON_ARRIVAL | {Stage.ACCEPTED},
    Stage.ACCEPTED: FINAL_STAGES - {Stage.REJECTED} | {Stage.STARTED},
    Stage.STARTED: {Stage.COMPLETED, Stage.FAILED, Stage.CANCELLED, Stage.SUPERSEDED, Stage.EXPIRED},
}


@pytest.mark.parametrize("after", Stage)
def test_stages_on_board_follow_each_other_and_none_follows_a_final_one(after: Stage) -> None:
    assert {stage for stage in Stage if may_follow(stage, after)} == MAY_FOLLOW.get(after, set())


def test_the_groups_of_stages() -> None:
    assert {Stage.RECEIVED, Stage.ACCEPTED} == NOT_STARTED
    assert {Stage.RECEIVED, Stage.ACCEPTED, Stage.STARTED} == ONBOARD
    assert {Stage.RECEIVED, Stage.ACCEPTED, Stage.REJECTED, Stage.SKIPPED} == NEVER_STARTED


@pytest.mark.parametrize(
    ("known", "report", "counts"),
    [
        (None, (Stage.RECEIVED, 0), True),
        ((Stage.UNKNOWN, 9), (Stage.RECEIVED, 0), True),
        ((Stage.QUEUED, 9), (Stage.RECEIVED, 0), True),
        ((Stage.STARTED, 5), (Stage.ACCEPTED, 4), False),
        ((Stage.ACCEPTED, 5), (Stage.STARTED, 5), True),
        ((Stage.ACCEPTED, 5), (Stage.STARTED, 6), True),
        ((Stage.STARTED, 5), (Stage.COMPLETED, 4), True),
        ((Stage.COMPLETED, 5), (Stage.STARTED, 6), False),
        ((Stage.COMPLETED, 5), (Stage.FAILED, 6), False),
    ],
)
def test_a_report_counts_unless_it_is_older_or_the_end_is_known(
    known: tuple[Stage, int] | None, report: tuple[Stage, int], counts: bool
) -> None:
    before = None if known is None else StageReport(known[0], "", known[1])
    assert StageReport(report[0], "", report[1]).counts_after(before) is counts
