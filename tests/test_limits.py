from __future__ import annotations

import os

import pytest

from waypointctl.limits import LIMITS, VARIABLE, limit, limit_hint, over_limit, set_limits, size_text


@pytest.fixture(autouse=True)
def _own_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "")


@pytest.mark.parametrize(
    ("text", "name", "value"),
    [
        ("policy-file=256MiB", "policy-file", 256 * 2**20),
        ("policy-file=1 GiB", "policy-file", 2**30),
        ("policy-file=12", "policy-file", 12),
    ],
)
def test_a_limit_that_was_set_is_in_force(text: str, name: str, value: int) -> None:
    before = {each: limit(each) for each in LIMITS}
    set_limits([text])
    assert {each: limit(each) for each in LIMITS} == before | {name: value}
    assert os.environ[VARIABLE], "the processes that are started have it too"
    set_limits(["sb3-archive=1KiB"])
    assert limit(name) == value, "another one changes nothing of it"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("policies=1MiB", "there is no limit 'policies'; there are: policy-file"),
        ("policy-file", "'policy-file': expected a size such as 256MiB or 1GiB"),
        ("policy-file=", "expected a size"),
        ("policy-file=0", "expected a size"),
        ("policy-file=-1MiB", "expected a size"),
        ("policy-file=1 parsec", "expected a size"),
        ("policy-file=1MiB,sb3-archive=1MiB", "expected a size"),
        ("policy-file=9999999999999999999999", "expected a size"),
    ],
)
def test_what_is_no_limit_is_refused(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        set_limits([text])


@pytest.mark.parametrize("name", LIMITS)
def test_what_the_hint_says_raises_the_limit(name: str) -> None:
    option = limit_hint(name).partition("--limit ")[2].partition(" ")[0]
    set_limits([option])
    assert limit(name) == 2 * LIMITS[name].default
    needed = limit_hint(name, 123_456_789).partition("--limit ")[2].partition(" ")[0]
    set_limits([needed])
    assert limit(name) == 2**27, "enough, in a whole unit"
    assert limit_hint(name, 2**27) == limit_hint(name, 123_456_789)


@pytest.mark.parametrize(
    ("found", "said"),
    [(2, "2 B"), (10_239, "10,239 B"), (10_241, "11 KiB"), (153_600, "150 KiB"), (2**40, "1,024 GiB")],
)
def test_what_is_over_a_limit_is_told_in_short_units(found: int, said: str) -> None:
    set_limits(["policy-file=1"])
    assert over_limit("policy-file", found) == f"has {said}; the limit policy-file is 1 B"
    assert over_limit("policy-work", found, "steps").startswith(f"has {found:,} steps; the limit policy-work is 8,5")


def test_a_size_is_told_in_whole_units() -> None:
    assert [size_text(size) for size in (1, 1024, 1536, 64 * 2**20, 2**31)] == [
        "1 B",
        "1 KiB",
        "1536 B",
        "64 MiB",
        "2 GiB",
    ]
