"""The paper's paths with next to no time: training's tests are not about walking them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import pytest

from waypointctl.evaluation.suite import Suite, load_suite
from waypointctl.task.course import Deadline
from waypointctl.training import train


@pytest.fixture(autouse=True, scope="session")
def _hardly_any_evaluation() -> Iterator[None]:
    @cache
    def hurried(name: str) -> Suite:
        return load_suite(name).model_copy(update={"deadline": Deadline(first_s=0.1, further_s=0)})

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(train, "load_suite", hurried)
        yield
