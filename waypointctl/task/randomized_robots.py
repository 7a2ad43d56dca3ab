"""The robots of a batch with the values drawn for each: actuator latency, body and sensors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl.seeding import restore_stream, restore_streams, stream, stream_words, streams_words
from waypointctl.sim.stepping import RobotBatch
from waypointctl.task.config import DRAWN, DomainRandomization, SensorNoise
from waypointctl.task.view import Body

FloatArray: TypeAlias = NDArray[np.float64]
Ids: TypeAlias = NDArray[np.intp]
Arrays: TypeAlias = dict[str, NDArray[Any]]


class RandomizedRobots:
    """The randomized values of a batch's robots, and their effect on motion and observations.

    Robot i draws from stream(seed, "variation", i), whatever the other robots do; sensors draw from
    stream(seed, "sensor noise"), all together.

    Attributes:
        drawn: (n, 4) between 0 and 1, for each robot's present episode: how far between the bounds each parameter of
            `DRAWN` is. One that does not vary is drawn too, so that the others do not depend on it.
    """

    def __init__(self, randomization: DomainRandomization, batch: RobotBatch) -> None:
        """Begin with the model's own values; `seed` them, then `begin` their first episodes.

        Raises:
            InputError: a latency is not a whole number of the robot's physics steps.
        """
        robot, num_robots = batch.robot, len(batch.qpos)
        self._randomization = randomization
        self._batch = batch
        self._streams: list[np.random.Generator] = []
        self._sensors: NoisySensors | None = None
        self.drawn: FloatArray = np.zeros((num_robots, len(DRAWN)))
        self.latency: ActuatorLatency | None = None
        if randomization.latency_s is not None:
            _, longest = randomization.latency_steps(robot)
            self.latency = ActuatorLatency(num_robots, robot.num_actions, robot.substeps, longest)

    def seed(self, seed: int) -> None:
        """Draw from the streams of another seed from here on."""
        robots = len(self.drawn) if self._randomization.any_drawn else 0
        self._streams = [stream(seed, "variation", i) for i in range(robots)]
        noise = self._randomization.sensor_noise
        if noise is not None:
            self._sensors = NoisySensors(noise, len(self._batch.robot.joint_names), stream(seed, "sensor noise"))

    def begin(self, ids: Ids) -> None:
        """Begin an episode with the robots `ids` (k,): draw their values."""
        if self._randomization.any_drawn:
            self.drawn[ids] = np.stack([self._streams[i].random(len(DRAWN)) for i in ids])
            self._apply(ids)
        if self.latency is not None:
            self.latency.switch_off(ids)

    def values(self, ids: Ids) -> dict[str, FloatArray]:
        """Return what was drawn for the present episodes of the robots `ids` (k,), by its name."""
        return self._randomization.values(self.drawn[ids], self._batch.robot)

    def step(self, applied: FloatArray) -> FloatArray:
        """Step one control period with actions (n, nu); return what the motors held at its end (n, nu)."""
        if self.latency is not None:
            return self.latency.step(applied, self._batch.step_physics)
        self._batch.step(applied)
        return applied

    def seen(self, body: Body) -> Body:
        """Return bodies as their sensors give them."""
        return body if self._sensors is None else self._sensors.read(body)

    def state(self) -> Arrays:
        """Return all arrays needed to continue bit for bit, by name; none without randomization."""
        arrays: Arrays = {}
        if self._randomization.any_drawn:
            arrays |= {"drawn": self.drawn, "streams": streams_words(self._streams)}
        if self.latency is not None:
            arrays["commanded"] = self.latency.commanded
        if self._sensors is not None:
            arrays["sensors"] = stream_words(self._sensors.rng)
        return arrays

    def restore(self, arrays: Arrays) -> None:
        """Continue from what `state` returned.

        Raises:
            KeyError, ValueError: it is of other robots.
        """
        if self._randomization.any_drawn:
            self.drawn[:] = arrays["drawn"]
            restore_streams(self._streams, arrays["streams"])
            self._apply(np.arange(len(self.drawn)))
        if self.latency is not None:
            self.latency.commanded[:] = arrays["commanded"]
        if self._sensors is not None:
            restore_stream(self._sensors.rng, arrays["sensors"])

    def _apply(self, ids: Ids) -> None:
        """Apply the drawn values to the robots `ids` (k,)."""
        batch = self._batch
        values = self.values(ids)
        for name, change in (
            ("mass_factor", batch.scale_mass),
            ("friction_factor", batch.scale_friction),
            ("gravity_mps2", batch.set_gravity),
        ):
            if name in values:
                change(ids, values[name])
        if self.latency is not None:
            self.latency.steps[ids] = np.rint(values["latency_s"] / batch.robot.physics_period_s)


class ActuatorLatency:
    """Actions of n robots that have not reached their motors yet.

    A robot's latency is a whole number of physics steps, so an action may take effect in the middle of a control
    period. Until the first action of an episode has arrived the motors are off.

    Attributes:
        steps: (n,) latency in physics steps.
        commanded: (n, m, nu) the latest actions, newest first: as many as the longest latency needs.
    """

    def __init__(self, num_robots: int, num_actions: int, substeps: int, longest: int) -> None:
        """Make the queues, with a latency of 0 and `substeps` physics steps in a control period.

        longest: the largest that `steps` will be set to, in physics steps.
        """
        self.steps: NDArray[np.int64] = np.zeros(num_robots, np.int64)
        self.commanded: FloatArray = np.zeros((num_robots, 1 - (-longest // substeps), num_actions))
        self._substeps = substeps
        self._robots = np.arange(num_robots)

    def switch_off(self, ids: Ids) -> None:
        """Discard the pending actions of the robots `ids` (k,): a new episode begins."""
        self.commanded[ids] = 0.0

    def step(self, actions: FloatArray, step_physics: Callable[[FloatArray], None]) -> FloatArray:
        """Command actions (n, nu) and let one control period pass; return what the motors held at its end (n, nu).

        step_physics: holds the motors at what it is given, (n, nu), for one physics step.
        """
        self.commanded[:, 1:] = self.commanded[:, :-1].copy()
        self.commanded[:, 0] = actions
        held = actions
        for substep in range(self._substeps):
            # The newest action that was commanded at least `steps` physics steps before this one.
            age = (self.steps - substep + self._substeps - 1) // self._substeps
            held = self.commanded[self._robots, age]
            step_physics(held)
        return held


class NoisySensors:
    """The sensors of a batch of robots.

    All robots read from one stream, row by row: a generator for each would take longer than the physics. So the noise
    of robot i depends on the number of robots, and on when the others began an episode. The same batch with the same
    seed has the same noise. A reading takes the same count of numbers from the stream, whichever sensors are noisy.
    """

    def __init__(self, noise: SensorNoise, num_joints: int, rng: np.random.Generator) -> None:
        """Make the sensors of robots with `num_joints` joints, which draw from rng."""
        self.rng = rng
        torso = (noise.position_m, noise.velocity_mps, noise.gyroscope_radps, noise.attitude_rad)
        joints = (noise.joint_angle_rad, noise.joint_speed_radps)
        self._deviation: FloatArray = np.concatenate([np.repeat(torso, 3), np.repeat(joints, num_joints)])
        self._joint_speeds = 12 + num_joints

    def read(self, body: Body) -> Body:
        """Return the bodies (n) as the sensors give them; `body` itself stays as it is.

        Roll and yaw stay within half a turn. `up` follows from roll and pitch.
        """
        off = self.rng.standard_normal((len(body.up), len(self._deviation))) * self._deviation
        roll, pitch = _within_half_a_turn(body.roll + off[:, 9]), body.pitch + off[:, 10]
        return replace(
            body,
            position=body.position + off[:, 0:3],
            velocity=body.velocity + off[:, 3:6],
            rates=body.rates + off[:, 6:9],
            roll=roll,
            pitch=pitch,
            yaw=_within_half_a_turn(body.yaw + off[:, 11]),
            up=np.cos(roll) * np.cos(pitch),
            joints=body.joints + off[:, 12 : self._joint_speeds],
            joint_rates=body.joint_rates + off[:, self._joint_speeds :],
        )


def _within_half_a_turn(angle: FloatArray) -> FloatArray:
    """Return angles (n,) in [-pi, pi]; one that is there already stays as it is, to the last bit."""
    over = np.abs(angle) > math.pi
    return np.where(over, np.remainder(angle + math.pi, 2 * math.pi) - math.pi, angle)
