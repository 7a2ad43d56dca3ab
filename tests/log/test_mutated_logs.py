"""Logs mutated at random are read or refused, and what is read of them is what the mcap library reads."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.budget import examples
from tests.log.fake_flight import header
from tests.log.mutations import mutated
from waypointctl.errors import LogError
from waypointctl.log.audit import audit
from waypointctl.log.comparison import Diverged
from waypointctl.log.reader import LogReader, open_log
from waypointctl.log.same_records import compare_readers, compare_records

CASES = examples(80)


def mutations(base: bytes, seed: int) -> Iterator[bytes]:
    rng = np.random.default_rng(seed)
    return (mutated([base], rng)[1] for _ in range(CASES))


@pytest.mark.parametrize("seed", range(4))
def test_what_passes_has_the_messages_that_were_written(log_path: Path, tmp_path: Path, seed: int) -> None:
    written = raw(open_log(log_path))
    path = tmp_path / "mutated.mcap"
    refused = 0
    for file in mutations(log_path.read_bytes(), seed):
        path.write_bytes(file)
        try:
            log = open_log(path)
            audit(log)
            compare_records(log, header())
            compare_readers(log)
        except (LogError, Diverged):
            refused += 1
        else:
            assert raw(log) == written
    assert refused > CASES / 2


@pytest.mark.parametrize("seed", range(4, 6))
def test_what_is_cut_short_is_read_as_far_as_it_is_whole(log_path: Path, tmp_path: Path, seed: int) -> None:
    path = tmp_path / "mutated.mcap"
    for file in mutations(log_path.read_bytes(), seed):
        path.write_bytes(file[: len(file) * 9 // 10])
        try:
            messages = [*open_log(path, allow_truncated=True).messages()]
        except LogError as error:
            assert str(error).startswith(f"{path}: ")  # noqa: PT017 - some are refused, and some are read
        else:
            assert all(message is not None for message in messages)


def raw(log: LogReader) -> list[tuple[str, tuple[object, ...]]]:
    """Return every message with its topic."""
    return [(topic, message[1:]) for topic, message in log.raw_messages()]
