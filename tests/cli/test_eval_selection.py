"""Trials that a policy was chosen by are not saved as a result of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.flying import Program
from tests.conftest import describe
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.manifest import SelectionRecord

SUITE = """\
name: easy
trials: 1
acceptance: {size: 2 m}
deadline: {first: 0.2 s, further: 0 s}
cases: [{name: near, waypoints: [[0.2, 0]]}]
"""


@pytest.fixture
def chosen(yard: Path, make_policy: Callable[..., LoadedPolicy]) -> Callable[[str], None]:
    """Make the policy `picked`, chosen with seed 7 by a suite; there are one in a file, and one that it is not."""

    def make(suite: str) -> None:
        record = SelectionRecord(suite=suite, seed=7, trials=9, successes=9, candidates=2, last_step=9, stop_at=None)
        training = describe().training.model_copy(update={"selection": record})
        make_policy(yard / "picked", gain=0.0, name="picked", training=training)

    (yard / "file.yaml").write_text(SUITE)
    (yard / "other.yaml").write_text(SUITE.replace("easy", "other"))
    return make


@pytest.mark.parametrize("suite", ["file.yaml", "../suites/file.yaml", "suites/easy.yml", "easy"])
def test_trials_that_a_policy_was_chosen_by_are_not_saved(
    chosen: Callable[[str], None], program: Program, suite: str
) -> None:
    chosen(suite)
    asked = ("eval", "still", "picked", "--suite", "file.yaml")
    code, out, err = program(*asked, "--seed", "7", "--acceptance", "box:1", "--save")
    assert (code, out) == (2, "")
    assert err.startswith("error: picked: --save: policy 'picked' was selected")
    assert f"(suite '{suite}', seed 7)" in err
    assert not [*Path().glob("*/evaluation*")]
    code, _, err = program(*asked, "--seed", "7")
    assert (code, err.count("warning: picked: "), len(err.splitlines())) == (0, 1, 1)


def test_other_trials_are_saved_without_a_warning(chosen: Callable[[str], None], program: Program) -> None:
    chosen("file.yaml")
    for other in (("--suite", "file.yaml"), ("--suite", "other.yaml", "--seed", "7")):
        code, _, err = program("eval", "still", "picked", *other, "--save")
        assert (code, [line for line in err.splitlines() if not line.startswith("written: ")]) == (0, [])
    assert len([*Path("picked").glob("evaluation-*.json")]) == 2
