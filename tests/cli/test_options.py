from __future__ import annotations

import pytest
from typer.testing import CliRunner

from tests.cli.flying import Program
from waypointctl.cli.app import app


@pytest.mark.parametrize("group", [(), ("policies",), ("study",)])
def test_no_summary_of_a_command_is_cut(group: tuple[str, ...]) -> None:
    shown = CliRunner().invoke(app, [*group, "--help"], env={"COLUMNS": "80"}).output
    summaries = shown.partition("Commands:\n")[2].splitlines()
    assert summaries
    assert not [line for line in summaries if "..." in line]


@pytest.mark.parametrize(
    ("rate", "message"),
    [
        ("95", "95 is not a rate from 0 to 1: 95 % is 0.95."),
        ("-0.1", "-0.1 is not a rate from 0 to 1."),
        ("950", "950 is not a rate from 0 to 1."),
        ("nan", "nan is not a rate from 0 to 1."),
    ],
)
def test_a_rate_in_per_cent_is_refused_and_said_as_a_rate(program: Program, rate: str, message: str) -> None:
    code, out, err = program("eval", "nothing", "--require", rate)
    assert (code, out) == (2, "")
    assert err.endswith(f"Invalid value for '--require': {message}\n")
