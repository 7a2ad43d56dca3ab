from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from waypointctl.mission.fields import Acceptance
from waypointctl.task.progress import reached

GOAL = (3.0, -2.0)
JUST_LESS = np.nextafter(0.5, 0.0)


@pytest.mark.parametrize(
    ("dx", "dy", "in_box", "in_radius"),
    [
        (0.0, 0.0, True, True),
        (JUST_LESS, 0.0, True, True),
        (0.0, -JUST_LESS, True, True),
        (0.5, 0.0, False, False),  # on the edge is outside: the paper's |PX - GX| < BX
        (0.0, -0.5, False, False),
        (JUST_LESS, JUST_LESS, True, False),
        (-0.4, 0.4, True, False),  # 0.566 m away, in the box's corner
        (0.3, -0.4, True, False),  # 0.5 m away exactly
        (0.3, -0.3999, True, True),
        (0.6, 0.0, False, False),
        (0.0, 0.6, False, False),
    ],
)
def test_the_box_and_the_radius_end_where_they_say(dx: float, dy: float, in_box: bool, in_radius: bool) -> None:
    position, goal = np.array([[dx, dy, 0.5]]), np.zeros((1, 2))
    assert reached(Acceptance(shape="box", size_m=0.5), position, goal) == [in_box]
    assert reached(Acceptance(shape="radius", size_m=0.5), position, goal) == [in_radius]


def test_each_robot_has_its_own_goal() -> None:
    position = np.array([[3.1, -2.1], [3.1, -2.1], [0.0, 0.0]])
    goal = np.array([GOAL, (9.0, 9.0), (0.1, 0.0)])
    assert reached(Acceptance(shape="box", size_m=0.2), position, goal).tolist() == [True, False, True]


@pytest.mark.parametrize(("shape", "size"), [("circle", 0.5), *(("box", size) for size in (0.0, -0.5, np.nan, np.inf))])
def test_a_shape_and_a_size_that_there_is_not_are_refused(shape: str, size: float) -> None:
    with pytest.raises(ValidationError):
        Acceptance.model_validate({"shape": shape, "size_m": size})
