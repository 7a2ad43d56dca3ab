"""When a picture is taken, and of which state."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.drawing import require_rendering
from tests.flight.flying import STILL, UNDER_FOOT, Scripted, mission_of, only, times_ns
from waypointctl.flight.fly import fly
from waypointctl.flight.operator.requests import planned_waypoints
from waypointctl.flight.sink import OnboardCamera, with_pictures
from waypointctl.log.messages import Event, EventKind, Message, Picture, State
from waypointctl.log.png import SOFTWARE, TITLE, texts_of
from waypointctl.mission.mission import Mission
from waypointctl.robots.load import load_robot

OBSERVED = {**UNDER_FOOT, "observe": True}


def told(event: Event, state: State) -> Picture:
    """Make a picture that tells what it is of."""
    return Picture(event.time_ns, f"{event.waypoint} {state.time_ns}", "png", state.qpos.tobytes())


def pictured(mission: Mission) -> list[Message]:
    messages: list[Message] = []
    fly(mission, Scripted(STILL), with_pictures(messages.append, told))
    return messages


def test_each_observation_has_a_picture_right_after_its_state() -> None:
    messages = pictured(mission_of(OBSERVED, UNDER_FOOT, OBSERVED, delay_ms=100))
    taken = times_ns(EventKind.OBSERVATION_TAKEN, messages)
    assert [(it.time_ns, it.frame_id) for it in only(Picture, messages)] == [
        (taken[0], f"0 {taken[0]}"),
        (taken[1], f"2 {taken[1]}"),
    ]
    for at, message in enumerate(messages):
        if isinstance(message, Picture):
            before = messages[at - 1]
            assert isinstance(before, State)
            assert message.data == before.qpos.tobytes()


def test_without_an_observation_there_is_no_picture() -> None:
    assert not only(Picture, pictured(mission_of(UNDER_FOOT)))


def test_the_rest_of_the_flight_is_the_same() -> None:
    mission = mission_of(OBSERVED)
    plain: list[Message] = []
    fly(mission, Scripted(STILL), plain.append)
    others = [message for message in pictured(mission) if not isinstance(message, Picture)]
    assert list(map(repr, others)) == list(map(repr, plain))


def test_a_robot_at_rest_is_pictured_as_it_stands() -> None:
    messages = pictured(mission_of({**OBSERVED, "hold_s": 60.0}, delay_ms=5000))
    (picture,) = only(Picture, messages)
    (taken_ns,) = times_ns(EventKind.OBSERVATION_TAKEN, messages)
    rest_ns = times_ns(EventKind.REST_STARTED, messages)[0]
    assert rest_ns < taken_ns == picture.time_ns
    assert picture.data == next(it for it in only(State, messages) if it.time_ns >= taken_ns).qpos.tobytes()


def test_a_camera_that_takes_none_leaves_the_flight_as_it_is() -> None:
    messages: list[Message] = []
    fly(mission_of(OBSERVED), Scripted(STILL), with_pictures(messages.append, lambda event, state: None))
    assert len(times_ns(EventKind.OBSERVATION_TAKEN, messages)) == 1
    assert not only(Picture, messages)


def test_a_camera_that_is_not_asked_sets_nothing_up(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise AssertionError("it was set up")

    monkeypatch.setattr("waypointctl.sim.camera.MountedCamera.__init__", fail)
    with OnboardCamera(load_robot("ant"), ()) as camera:
        assert (camera.taken, camera.trouble) == (0, "")


def test_a_camera_that_cannot_draw_says_why_once_and_takes_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    mission = mission_of(OBSERVED, OBSERVED)
    messages: list[Message] = []
    with OnboardCamera(load_robot("ant"), planned_waypoints(mission)) as camera:
        fly(mission, Scripted(STILL), with_pictures(messages.append, camera))
    assert not only(Picture, messages)
    assert (camera.taken, camera.renderer) == (0, "")
    assert camera.trouble == "MUJOCO_GL=disable turns rendering off\n  Unset MUJOCO_GL to have pictures."


def test_the_camera_names_the_waypoint_and_itself(tmp_path: Path) -> None:
    require_rendering()
    mission = mission_of({**OBSERVED, "name": "Höhle"})
    messages: list[Message] = []
    with OnboardCamera(load_robot("ant"), planned_waypoints(mission)) as camera:
        fly(mission, Scripted(STILL), with_pictures(messages.append, camera))
        (picture,) = only(Picture, messages)
        assert (picture.frame_id, picture.format, camera.taken) == ("camera", "png", 1)
        assert texts_of(picture.data) == {TITLE: "Höhle", SOFTWARE: camera.renderer}
        state = next(it for it in only(State, messages) if it.time_ns == picture.time_ns)
        assert np.isfinite(state.qpos).all()
    for part in ("OpenGL", "MuJoCo", "Pillow"):
        assert part in camera.renderer
