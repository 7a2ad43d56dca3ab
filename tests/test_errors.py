from __future__ import annotations

import pytest

from waypointctl.errors import InputError


@pytest.mark.parametrize(
    ("hint", "said"), [("name another", "Name another"), ("Name it.", "Name it."), ("--force does", "--force does")]
)
def test_a_hint_begins_with_a_capital_letter_whoever_writes_it(hint: str, said: str) -> None:
    assert str(InputError("is wrong", where="f", hint=hint)) == f"f: is wrong\n  {said}"
    assert str(InputError("is wrong", where="f")) == "f: is wrong"
