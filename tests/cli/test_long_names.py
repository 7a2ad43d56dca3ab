"""A name that is too long to be looked up is one message and exit code 2, wherever it is given."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.flying import EASY, Program

TOO_LONG = "x" * 5000


@pytest.mark.parametrize(
    "arguments",
    [
        ("run", "easy.yaml", "--policy", TOO_LONG),
        ("run", "easy.yaml", "--out", TOO_LONG),
        ("run", "long-policy.yaml"),
        ("run", TOO_LONG),
        ("eval", TOO_LONG),
        ("eval", "still", "--out", TOO_LONG),
        ("eval", "still", "--suite", TOO_LONG),
        ("policies", TOO_LONG),
        ("policies", "show", TOO_LONG),
        ("validate", TOO_LONG),
        ("train", TOO_LONG),
        ("train", "recipe.yaml", "--out", TOO_LONG),
        ("train", "recipe.yaml", "--runs", TOO_LONG),
    ],
    ids=lambda arguments: " ".join(arguments).replace(TOO_LONG, "XXX"),
)
def test_it_is_refused(yard: Path, program: Program, arguments: tuple[str, ...]) -> None:
    (yard / "long-policy.yaml").write_text(EASY.replace("policy: still", f"policy: {TOO_LONG[:900]}"))
    (yard / "recipe.yaml").write_text("name: tiny\nphases: [{steps: 640}]\n")
    code, out, err = program(*arguments)
    assert code == 2
    assert "File name too long" in out + err
    assert "Traceback" not in err
    assert not (yard / "logs").exists()


def test_a_missions_policy_of_that_name_is_not_found(yard: Path, program: Program) -> None:
    (yard / "long-policy.yaml").write_text(EASY.replace("policy: still", f"policy: {TOO_LONG[:900]}"))
    code, out, _ = program("validate", "long-policy.yaml")
    assert code == 2
    assert ": policy: 'xxx" in out
