"""A log to read, written once."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.log.fake_flight import flight, header
from waypointctl.log.writer import LogWriter


@pytest.fixture(scope="session")
def log_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The whole fake flight, four simulated seconds; not to be changed."""
    path = tmp_path_factory.mktemp("log") / "flight.mcap"
    with LogWriter(path, header()) as sink:
        for message in flight():
            sink(message)
    return path
