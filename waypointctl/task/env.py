"""One robot on its course as a Gymnasium environment: the batched env with a batch of one."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.mission.fields import Start
from waypointctl.robots.robot import Robot
from waypointctl.sim.actions import refuse_bad_action
from waypointctl.task.batched import BatchedWaypointEnv, Step
from waypointctl.task.config import TaskConfig
from waypointctl.task.progress import CourseProgress

try:
    import gymnasium
except ModuleNotFoundError as error:
    problem = "waypointctl's environment needs gymnasium, which is not installed: pip install 'waypointctl[train]'"
    raise ModuleNotFoundError(problem, name=error.name) from error

FloatArray = NDArray[np.float64]

if TYPE_CHECKING:
    from waypointctl.sim.camera import Camera, Marker
    from waypointctl.sim.viewer import Viewer

RENDER_MODES: Final = ("human", "rgb_array")
OPTIONS: Final = ("waypoints", "position_m", "heading_rad")

# MuJoCo resets the simulation at a larger coordinate (mjMAXVAL), so no observation is larger.
_LARGEST: Final = 1e10


class WaypointEnv(gymnasium.Env[FloatArray, NDArray[np.float32]]):
    """One robot on a course of waypoints.

    Observation: (k,) float64 in the layout that the config names. Action: (nu,) float32 in [-1, 1], a number for
    each actuator; robot.yaml defines its meaning. An episode is terminated by a fall, truncated by its
    deadline and by success.

    `info` of a step has `reward_<term>` for each term of the reward, `waypoint_index` (of the current waypoint, from
    0), `waypoint_reached` (in this step), `success`, `fell` and `timed_out`; that of the last step has `is_success`,
    which stable-baselines3's EvalCallback counts, and `end_reason`: "success", "fall" or "time_out". That of a reset
    has `waypoint_index` and `waypoints` (m, 2) [m], and what domain randomization drew, under its name there, such as
    `mass_factor`.
    """

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES), "render_fps": 50}  # noqa: RUF012  # as Gymnasium's

    def __init__(self, config: TaskConfig | None = None, render_mode: str | None = None) -> None:
        """Make the robot's world.

        Args:
            config: the task; default: the paper's course and waypoints.
            render_mode: "rgb_array": `render` returns a picture (480, 640, 3) uint8; "human": a window shows every
                step at the robot's own speed, or a warning why there is no window; None: nothing is drawn.

        Raises:
            InputError: the render mode is unknown.
        """
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise InputError(f"unknown render_mode {render_mode!r}; allowed: {', '.join(RENDER_MODES)}, None")
        self.render_mode = render_mode
        self._config = config or TaskConfig()
        self._env = BatchedWaypointEnv(self._config, 1, 0, threads=1, autoreset=False)
        self._seeded = False
        self.metadata = self.metadata | {"render_fps": round(1e9 / self._env.robot.control_period_ns)}
        self._rendering = _Rendering(self._env.robot, render_mode) if render_mode else None
        largest = np.full(self._env.layout.size, _LARGEST)
        full_torque = np.ones(self._env.robot.num_actions, np.float32)
        self.observation_space = gymnasium.spaces.Box(-largest, largest, dtype=np.float64)
        self.action_space = gymnasium.spaces.Box(-full_torque, full_torque, dtype=np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[FloatArray, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: of every start and course from here on: robot 0's of a BatchedWaypointEnv with that seed.
            options: of this episode alone: "waypoints", the course (m, 2) [m] instead of a drawn one; "position_m",
                (2,) the torso's place at the start; "heading_rad", the robot's heading there.

        Raises:
            InputError: an unknown option, or a value of the wrong shape.
        """
        super().reset(seed=seed)
        given = options or {}
        waypoints = _waypoints(given)
        start = _start(given, self._config.start)
        if seed is not None or not self._seeded:
            self._env.seed(int(self.np_random.integers(2**63)) if seed is None else seed)
            self._seeded = True
        count = self._config.course.longest if waypoints is None else len(waypoints)
        if count > self._env.progress.waypoints.shape[1]:
            period_ns = self._env.robot.control_period_ns
            self._env.progress = CourseProgress(1, count, self._config.deadline, period_ns)
        self._env.config = replace(self._config, start=start)
        self._env.begin([0], waypoints)
        course = self._env.progress.waypoints[0, : self._env.progress.count[0]].copy()
        self._show()
        drawn = {name: float(value[0]) for name, value in self._env.randomized.values(np.array([0])).items()}
        return self._env.observe()[0], {"waypoint_index": 0, "waypoints": course, **drawn}

    def step(self, action: NDArray[np.float32]) -> tuple[FloatArray, float, bool, bool, dict[str, Any]]:
        """Step one control period with action (nu,), clipped to [-1, 1].

        Raises:
            InputError: the action has another shape, or a number that is not finite.
        """
        step = self._env.step(refuse_bad_action(action, self._env.robot.num_actions)[np.newaxis])
        self._show()
        terminated, truncated = bool(step.terminated[0]), bool(step.truncated[0])
        return step.observation[0], float(step.reward[0]), terminated, truncated, self._info(step)

    def render(self) -> NDArray[np.uint8] | None:
        """Return the picture of where the robot is, (480, 640, 3) uint8, in mode "rgb_array"; None in the others.

        Raises:
            NoRendering: no OpenGL renderer is available.
        """
        if self._rendering is None:
            gymnasium.logger.warn("render() does nothing without a render_mode: use 'rgb_array' or 'human'")
            return None
        return self._rendering.frame(*self._scene()) if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Close the window, and release the renderer."""
        if self._rendering is not None:
            self._rendering.close()

    def _show(self) -> None:
        if self._rendering is not None:
            self._rendering.show(*self._scene())

    def _scene(self) -> tuple[FloatArray, list[FloatArray]]:
        """Return qpos (nq,) and the waypoints that are ahead, each (2,) [m]."""
        progress = self._env.progress
        first, count = int(progress.index[0]), int(progress.count[0])
        return self._env.batch.qpos[0], list(progress.waypoints[0, first:count])

    def _info(self, step: Step) -> dict[str, Any]:
        success, fell = bool(step.success[0]), bool(step.terminated[0])
        end: dict[str, Any] = {}
        if len(step.ended):
            end = {"is_success": success, "end_reason": "success" if success else "fall" if fell else "time_out"}
        return end | {
            **{
                f"reward_{name}": float(value)
                for name, value in zip(self._env.reward.names, step.terms[0], strict=True)
            },
            "waypoint_index": int(self._env.progress.index[0]),
            "waypoint_reached": bool(step.reached[0]),
            "success": success,
            "fell": fell,
            "timed_out": bool(step.truncated[0]) and not success,
        }


class _Rendering:
    """Draws one robot and the waypoints that are ahead of it. The renderer is created at the first frame."""

    def __init__(self, robot: Robot, mode: str) -> None:
        """Draw in a mode. A window is opened at once; without a display there is a warning and no window."""
        self._robot = robot
        self._camera: Camera | None = None
        self._viewer: Viewer | None = None
        if mode == "human":
            from waypointctl.sim.viewer import Viewer

            try:
                self._viewer = Viewer(robot)
            except InputError as error:  # no reason to end a training; Gymnasium's checker makes every mode
                warnings.warn(f"no window is shown: {error}", stacklevel=3)

    def show(self, qpos: FloatArray, ahead: Sequence[FloatArray]) -> None:
        """Show the robot at qpos (nq,), and the waypoints ahead, each (2,) [m], where there is a window."""
        if self._viewer is not None:
            self._viewer.mark(_markers(ahead))
            self._viewer.show(qpos, self._robot.control_period_ns / 1e9)

    def frame(self, qpos: FloatArray, ahead: Sequence[FloatArray]) -> NDArray[np.uint8]:
        """Return the picture (480, 640, 3) uint8 of the robot at qpos (nq,), the first row on top."""
        from waypointctl.sim.camera import Camera, follow

        if self._camera is None:
            self._camera = Camera(self._robot, (), follow)
        self._camera.markers = tuple(_markers(ahead))
        return self._camera.take(qpos)

    def close(self) -> None:
        """Release the renderer, and close the window."""
        for drawing in (self._camera, self._viewer):
            if drawing is not None:
                drawing.close()
        self._camera = self._viewer = None


def _markers(ahead: Sequence[FloatArray]) -> list[Marker]:
    from waypointctl.sim.camera import Marker

    return [Marker("", float(x_m), float(y_m)) for x_m, y_m in ahead]


def _waypoints(options: Mapping[str, Any]) -> FloatArray | None:
    for name in options:
        if name not in OPTIONS:
            raise InputError(f"unknown option of reset: {name!r}; allowed: {', '.join(OPTIONS)}")
    given = options.get("waypoints")
    if given is None:
        return None
    waypoints = _numbers("waypoints", given)
    if waypoints.ndim != 2 or waypoints.shape[1] != 2 or not len(waypoints):
        raise InputError(f"options['waypoints'] has the shape {waypoints.shape}; expected (m, 2), one row per waypoint")
    return waypoints


def _start(options: Mapping[str, Any], start: Start) -> Start:
    if options.get("position_m") is not None:
        position = _numbers("position_m", options["position_m"])
        if position.shape != (2,):
            raise InputError(f"options['position_m'] has the shape {position.shape}; expected (2,), x and y in m")
        start = start.model_copy(update={"position_m": (float(position[0]), float(position[1]))})
    if options.get("heading_rad") is not None:
        heading = _numbers("heading_rad", options["heading_rad"])
        if heading.shape != ():
            raise InputError(f"options['heading_rad'] has the shape {heading.shape}; expected one number in rad")
        degrees = math.degrees(float(heading))
        start = start.model_copy(update={"heading_deg": degrees, "random_heading": False})
    return start


def _numbers(name: str, given: object) -> FloatArray:
    try:
        numbers = np.array(given, np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"options[{name!r}] must be numbers: {error}") from error
    if not np.isfinite(numbers).all():
        raise InputError(f"options[{name!r}] is {numbers.tolist()}; every number must be finite")
    return numbers
