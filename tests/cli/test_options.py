from __future__ import annotations

import pytest

from tests.cli.flying import Program


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
