"""What the robot's camera sees, held against a pinhole camera's own arithmetic."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.drawing import require_rendering
from waypointctl.robots.load import load_robot
from waypointctl.sim.camera import FOVY_DEG, HEIGHT, POST_M, WIDTH, Marker, MountedCamera, Pixels

FloatArray = NDArray[np.float64]

ROBOT = load_robot("ant")
PITCH_DEG = ROBOT.camera.pitch_deg
LEGS_ROW = 400  # below it the robot itself may be seen
HORIZON_ROW = HEIGHT / 2 * (1 - math.tan(math.radians(-PITCH_DEG)) / math.tan(math.radians(FOVY_DEG / 2)))
POSES = ((0.0, 0.0, 0.0), (4.0, -3.0, 0.7), (-12.0, 60.0, 2.9), (200.0, 1.0, -1.8))  # x, y [m], heading [rad]


@pytest.fixture(scope="module", autouse=True)
def _rendering() -> None:
    require_rendering()


@pytest.fixture(scope="module")
def bare() -> Iterator[MountedCamera]:
    """The camera of a robot in a world without markers."""
    camera = MountedCamera(ROBOT, [])
    yield camera
    camera.close()


def standing(x_m: float, y_m: float, heading_rad: float, roll_rad: float = 0.0) -> FloatArray:
    """Return qpos (nq,) of the robot in its stance: rolled about its own axis, then turned."""
    half, tilt = heading_rad / 2, roll_rad / 2
    turned = np.array([math.cos(half) * math.cos(tilt), math.cos(half) * math.sin(tilt)])
    rest = np.array([math.sin(half) * math.sin(tilt), math.sin(half) * math.cos(tilt)])
    return np.concatenate([[x_m, y_m, ROBOT.nominal_height_m], turned, rest, ROBOT.nominal])


def ahead(pose: tuple[float, float, float], forward_m: float, left_m: float) -> tuple[float, float]:
    """Return the place that is so far ahead and to the left of a robot."""
    x_m, y_m, heading = pose
    cos, sin = math.cos(heading), math.sin(heading)
    return x_m + forward_m * cos - left_m * sin, y_m + forward_m * sin + left_m * cos


def projected(forward_m: float, left_m: float, z_m: float) -> tuple[float, float]:
    """Return the column and row of a point that is so far ahead and to the left of the torso, and so high."""
    pitch = math.radians(PITCH_DEG)
    x, z = forward_m - ROBOT.camera.position_m[0], z_m - ROBOT.nominal_height_m - ROBOT.camera.position_m[2]
    depth, up = x * math.cos(pitch) + z * math.sin(pitch), z * math.cos(pitch) - x * math.sin(pitch)
    focal = HEIGHT / 2 / math.tan(math.radians(FOVY_DEG) / 2)  # [pixels]
    return WIDTH / 2 - focal * left_m / depth, HEIGHT / 2 - focal * up / depth


def orange(picture: Pixels, rows: int = LEGS_ROW) -> NDArray[np.intp]:
    """Return where markers are seen (n, 2), row and column, above the robot."""
    red, green, blue = (picture[:rows, :, i].astype(int) for i in range(3))
    return np.argwhere((red > 190) & (blue < 80) & (red - green > 30))


def seen(pose: tuple[float, float, float], *places: tuple[float, float]) -> Pixels:
    """Take a picture of nameless markers, each so far ahead and to the left."""
    camera = MountedCamera(ROBOT, [Marker("", *ahead(pose, *place)) for place in places])
    try:
        return camera.take(standing(*pose))
    finally:
        camera.close()


@pytest.mark.parametrize("pose", POSES)
def test_there_is_sky_above_the_horizon_and_ground_below(bare: MountedCamera, pose: tuple[float, float, float]) -> None:
    picture = bare.take(standing(*pose)).astype(int)
    assert picture.shape == (HEIGHT, WIDTH, 3)
    haze = 25  # rows
    sky, ground = picture[: round(HORIZON_ROW) - haze], picture[round(HORIZON_ROW) + haze : LEGS_ROW]
    assert (sky[..., 2] > sky[..., 0] + 20).all()
    assert (ground[..., 0] > ground[..., 2] + 20).all()
    assert ground[..., 0].std() > 4  # the checks


def test_the_robot_sees_its_own_front_legs(bare: MountedCamera) -> None:
    tan = bare.take(standing(0, 0, 0)).astype(int)[LEGS_ROW:]
    legs = (tan[..., 0] > 200) & (tan[..., 1] > 140) & (tan[..., 2] > 80)
    assert legs[:, : WIDTH // 2].sum() > 500
    assert legs[:, WIDTH // 2 :].sum() > 500


@pytest.mark.parametrize("pose", POSES[1:3])
@pytest.mark.parametrize("place", [(3.0, 0.0), (5.0, -2.0)])
def test_a_marker_is_where_a_pinhole_camera_would_see_it(
    pose: tuple[float, float, float], place: tuple[float, float]
) -> None:
    found = orange(seen(pose, place))
    column, top = projected(*place, POST_M)
    _, foot = projected(*place, 0.0)
    near = 2.0  # pixels, beside the knob's and the foot's own size
    scale = (foot - top) / POST_M
    assert found[:, 0].min() == pytest.approx(top - 0.08 * scale, abs=near)
    assert found[:, 0].max() == pytest.approx(foot + 0.2 * scale * math.sin(math.radians(20)), abs=near + 0.1 * scale)
    middle = found[abs(found[:, 0] - (top + foot) / 2) < 5, 1]  # of the post
    assert middle.mean() == pytest.approx((column + projected(*place, 0.0)[0]) / 2, abs=near)


def test_left_is_left() -> None:
    assert (orange(seen((0.0, 0.0, 0.0), (4.0, 1.0)))[:, 1] < WIDTH / 2).all()
    assert (orange(seen((0.0, 0.0, 0.0), (4.0, -1.0)))[:, 1] > WIDTH / 2).all()


def test_what_is_behind_or_too_far_is_not_seen() -> None:
    assert not len(orange(seen((0.0, 0.0, 0.0), (-4.0, 0.0), (500.0, 0.0))))


def test_a_post_right_before_the_camera_does_not_hide_the_view() -> None:
    found = orange(seen((0.0, 0.0, 0.0), (1.0, 0.9))[:, : WIDTH // 3], HEIGHT)
    column, row = projected(1.0, 0.9, 0.0)
    assert np.median(found, axis=0) == pytest.approx((row, column), abs=8)  # its foot
    assert found[:, 0].min() > row - 40


def test_a_name_stands_at_its_marker_in_the_letters_that_there_are() -> None:
    pose = (0.0, 0.0, 0.0)
    x_m, y_m = ahead(pose, 4.0, 0.0)
    nameless = seen(pose, (4.0, 0.0)).astype(int)
    column, row = projected(4.0, 0.0, POST_M)
    for name in ("rock", "Höhle \N{ROCKET}", "x" * 300):
        camera = MountedCamera(ROBOT, [Marker(name, x_m, y_m)])
        changed = np.argwhere(abs(camera.take(standing(*pose)) - nameless).sum(axis=2) > 0)
        camera.close()
        assert len(changed) > 50
        assert abs(changed[:, 0] - row).max() < 20
        assert changed[:, 1].min() > column - 10


def test_a_thousand_markers_are_not_too_many() -> None:
    places = [(2.0 + 0.1 * number, 0.0) for number in range(1000)]
    assert len(orange(seen((0.0, 0.0, 0.0), *places)))


def test_the_camera_stays_level_when_the_torso_rolls(bare: MountedCamera) -> None:
    upright, rolled = (bare.take(standing(1, 2, 0.5, roll_rad=roll)) for roll in (0.0, 0.4))
    np.testing.assert_array_equal(upright[:300], rolled[:300])
    assert (upright[LEGS_ROW:] != rolled[LEGS_ROW:]).any()


def test_the_same_state_is_the_same_picture(bare: MountedCamera) -> None:
    first = bare.take(standing(1, 2, 0.5))
    bare.take(standing(7, 7, 1.5))
    again = MountedCamera(ROBOT, [])
    np.testing.assert_array_equal(bare.take(standing(1, 2, 0.5)), first)
    np.testing.assert_array_equal(again.take(standing(1, 2, 0.5)), first)
    assert again.renderer == bare.renderer
    again.close()


def test_the_model_that_flies_knows_nothing_of_it(bare: MountedCamera) -> None:
    before = ROBOT.to_mjb()
    bare.take(standing(0, 0, 0))
    assert ROBOT.to_mjb() == before
    assert ROBOT.model.ntex == 1  # no sky
