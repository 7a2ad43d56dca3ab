"""The robots of a batch, each with what was drawn for it."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl.seeding import stream
from waypointctl.sim.batch import RobotBatch
from waypointctl.task.body import Body
from waypointctl.task.latency import ActuatorLatency
from waypointctl.task.sensor_noise import NoisySensors
from waypointctl.task.stream_state import restore_stream, stream_words
from waypointctl.task.variation import DRAWN, Variation

FloatArray = NDArray[np.float64]
Ids = NDArray[np.intp]
Arrays: TypeAlias = dict[str, NDArray[Any]]


class VariedRobots:
    """What the robots of a batch differ in, and how they move and see because of it.

    Robot i draws from stream(seed, "variation", i), whatever the other robots do; sensors draw from
    stream(seed, "sensor noise"), all together.

    Attributes:
        drawn: (n, 4) between 0 and 1, for each robot's present episode: how far between the bounds each parameter of
            `DRAWN` is. One that does not vary is drawn all the same, so that letting it vary shifts no other.
    """

    def __init__(self, variation: Variation, batch: RobotBatch) -> None:
        """Make robots as the model has them; `seed` them, then `begin` their first episodes.

        Raises:
            InputError: a latency is no whole number of the robot's physics steps.
        """
        robot, num_robots = batch.robot, len(batch.qpos)
        self._variation = variation
        self._batch = batch
        self._streams: list[np.random.Generator] = []
        self._sensors: NoisySensors | None = None
        self.drawn: FloatArray = np.zeros((num_robots, len(DRAWN)))
        self.latency: ActuatorLatency | None = None
        if variation.latency_s is not None:
            _, longest = variation.latency_steps(robot)
            self.latency = ActuatorLatency(num_robots, robot.num_actions, robot.substeps, longest)

    def seed(self, seed: int) -> None:
        """Draw from the streams of another seed from here on."""
        robots = len(self.drawn) if self._variation.any_drawn else 0
        self._streams = [stream(seed, "variation", i) for i in range(robots)]
        noise = self._variation.sensor_noise
        if noise is not None:
            self._sensors = NoisySensors(noise, len(self._batch.robot.joint_names), stream(seed, "sensor noise"))

    def begin(self, ids: Ids) -> None:
        """Begin an episode with the robots `ids` (k,): draw what they differ in."""
        if self._variation.any_drawn:
            self.drawn[ids] = np.stack([self._streams[i].random(len(DRAWN)) for i in ids])
            self._vary(ids)
        if self.latency is not None:
            self.latency.switch_off(ids)

    def values(self, ids: Ids) -> dict[str, FloatArray]:
        """Return what was drawn for the present episodes of the robots `ids` (k,), by its name in Variation."""
        return self._variation.values(self.drawn[ids], self._batch.robot)

    def step(self, applied: FloatArray) -> FloatArray:
        """Let one control period pass with actions (n, nu); return what the motors held at its end (n, nu)."""
        if self.latency is not None:
            return self.latency.step(applied, self._batch.step_physics)
        self._batch.step(applied)
        return applied

    def seen(self, body: Body) -> Body:
        """Return bodies as their sensors give them."""
        return body if self._sensors is None else self._sensors.read(body)

    def state(self) -> Arrays:
        """Return all that going on bit for bit needs, by name; nothing where nothing varies."""
        arrays: Arrays = {}
        if self._variation.any_drawn:
            arrays |= {"drawn": self.drawn, "streams": np.stack([stream_words(rng) for rng in self._streams])}
        if self.latency is not None:
            arrays["commanded"] = self.latency.commanded
        if self._sensors is not None:
            arrays["sensors"] = stream_words(self._sensors.rng)
        return arrays

    def restore(self, arrays: Arrays) -> None:
        """Go on from what `state` returned.

        Raises:
            KeyError, ValueError: it is of other robots.
        """
        if self._variation.any_drawn:
            self.drawn[:] = arrays["drawn"]
            for rng, words in zip(self._streams, arrays["streams"], strict=True):
                restore_stream(rng, words)
            self._vary(np.arange(len(self.drawn)))
        if self.latency is not None:
            self.latency.commanded[:] = arrays["commanded"]
        if self._sensors is not None:
            restore_stream(self._sensors.rng, arrays["sensors"])

    def _vary(self, ids: Ids) -> None:
        """Make the robots `ids` (k,) what was drawn for them."""
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
