"""A log that shows other readers another flight is not proved, whatever it says of the program that wrote it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.log.attacks import ATTACKS
from tests.log.forging import Forgery
from tests.replay.rewriting import Flown
from waypointctl.errors import LogError
from waypointctl.replay.verify import Verdict, verify

ELSEWHERE = {"source": "0" * 12}


@pytest.mark.parametrize(
    ("name", "named"), [*((name, {}) for name in ATTACKS), *((name, ELSEWHERE) for name in list(ATTACKS)[::10])]
)
def test_a_forged_file_diverges_at_the_record_or_is_damaged(
    flown: Flown, tmp_path: Path, name: str, named: dict[str, str]
) -> None:
    forgery = Forgery.of(flown.path.read_bytes())
    forgery.metadata().update(named)
    ATTACKS[name](forgery)
    path = tmp_path / "forged.mcap"
    path.write_bytes(forgery.file())
    try:
        found = verify(path)
    except LogError as error:
        assert "is damaged at byte" in str(error)  # noqa: PT017 - most of them are found by the proof
        return
    assert found.verdict is Verdict.DIVERGED
    where = found.first_divergence
    assert where is not None
    assert where.component in found.reason
    assert ("the other program may be the cause" in found.reason) is bool(named)


@pytest.mark.parametrize("compression", ["", "lz4"])
def test_a_file_that_is_packed_otherwise_is_equivalent_where_another_program_wrote_it(
    flown: Flown, tmp_path: Path, compression: str
) -> None:
    forgery = Forgery.of(flown.path.read_bytes())
    for chunk in forgery.chunks:
        chunk.compression = compression
    path = tmp_path / "packed.mcap"
    path.write_bytes(forgery.file())
    assert verify(path).verdict is Verdict.DIVERGED
    forgery.metadata().update(ELSEWHERE)
    path.write_bytes(forgery.file())
    found = verify(path)
    assert found.verdict is Verdict.EQUIVALENT, found
    assert found.not_compared[-1] == "the bytes of the file: its records are chunked or compressed differently"
    assert "the messages that mcap's streaming and seeking readers return" in found.checks[-1]
