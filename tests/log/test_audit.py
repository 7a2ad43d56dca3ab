"""A log that shows one reader another flight than the next is found, at the record that does it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.log.attacks import ATTACKS
from tests.log.fake_flight import header
from tests.log.forging import Forgery
from waypointctl.errors import LogError
from waypointctl.log.audit import audit
from waypointctl.log.comparison import Diverged
from waypointctl.log.reader import LogReader, open_log
from waypointctl.log.same_records import compare_readers, compare_records


def check(log: LogReader) -> None:
    """Check a log as one of another program is."""
    audit(log)
    compare_records(log, header())
    compare_readers(log)


@pytest.fixture
def forged(log_path: Path, tmp_path: Path) -> Callable[[Callable[[Forgery], None]], Path]:
    def forge(change: Callable[[Forgery], None]) -> Path:
        forgery = Forgery.of(log_path.read_bytes())
        change(forgery)
        path = tmp_path / "forged.mcap"
        path.write_bytes(forgery.file())
        return path

    return forge


def test_what_is_taken_apart_and_put_together_is_the_same_file(log_path: Path) -> None:
    assert Forgery.of(log_path.read_bytes()).file() == log_path.read_bytes()


def test_a_log_as_it_is_written_passes(log_path: Path) -> None:
    check(open_log(log_path))


@pytest.mark.parametrize("compression", ["", "lz4", "zstd"])
def test_so_does_one_that_is_chunked_and_compressed_otherwise(
    forged: Callable[[Callable[[Forgery], None]], Path], compression: str
) -> None:
    def repack(forgery: Forgery) -> None:
        first, second, *_ = forgery.chunks
        second.inner = first.inner + second.inner
        forgery.data.remove(first)
        for chunk in forgery.chunks:
            chunk.compression = compression

    check(open_log(forged(repack)))


@pytest.mark.parametrize("name", ATTACKS)
def test_what_is_hidden_doubled_out_of_place_or_not_as_the_index_says_is_found(
    forged: Callable[[Callable[[Forgery], None]], Path], name: str
) -> None:
    path = forged(ATTACKS[name])
    try:
        log = open_log(path)
    except LogError as error:
        assert "is damaged at byte" in str(error)  # noqa: PT017 - most attacks are found by the check below
        return
    with pytest.raises(Diverged) as caught:
        check(log)
    difference = caught.value.where
    assert difference.logged != difference.replayed
    assert difference.topic.startswith("/") or difference.topic in ("file", "metadata", "attachment")
    if difference.topic == "file":
        assert any(word in difference.component for word in (" at byte ", "schema of ", "channel of ", "attachment "))
