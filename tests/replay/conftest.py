"""A flight to prove, and to change."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.replay.rewriting import Flown, fly_once
from waypointctl.policy.bundle import LoadedPolicy


@pytest.fixture(scope="session")
def flown(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Flown:
    """A short flight over a link, with its log; not to be changed."""
    folder: Path = tmp_path_factory.mktemp("flight")
    return fly_once(folder, make_policy(folder / "policy", seed=7))
