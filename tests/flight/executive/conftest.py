"""An executive that is idle, and one that is under way."""

from __future__ import annotations

import pytest

from tests.flight.executive.rig import A, B, Rig


@pytest.fixture
def rig() -> Rig:
    return Rig()


@pytest.fixture
def walking(rig: Rig) -> Rig:
    """Command 1 is under way to a, and b comes after it."""
    rig.command(0.0, A, B)
    return rig
