"""The logged flight as the witness of its replay: each message is compared as it is made again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from waypointctl.log.messages import Action, GroundControl, Message, Observation, State, Telemetry
from waypointctl.log.topics import BY_KIND
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.difference import difference, different_bits
from waypointctl.replay.verdict import Divergence

FloatArray = NDArray[np.float64]

# Another processor may round a network's sums in another order; more than this is another action.
ACTION_TOLERANCE = 1e-4


class Diverged(Exception):
    """The replay has parted from the log; `rounding` says that another way of rounding may be why."""

    def __init__(self, where: Divergence, *, rounding: bool = False) -> None:
        """Say where."""
        self.where = where
        self.rounding = rounding
        super().__init__(where.component)


class LogEnded(Exception):
    """The log holds no more: it was cut short."""


class Witness:
    """A sink for the replay's messages, with the logged ones to hold them against.

    What is computed with numpy's trigonometry, observations and telemetry, may be rounded otherwise on another
    processor. States never may: physics goes on from them.
    """

    def __init__(self, logged: Iterator[Message], *, bitwise: bool) -> None:
        """Take the logged messages in their order; without `bitwise` let numpy round otherwise."""
        self._logged = logged
        self._rounded = () if bitwise else (Observation, Telemetry, GroundControl)
        self._next: Message | None = next(logged, None)
        self._step = 0
        self._time_ns = 0
        self.compared: Counter[str] = Counter()

    def __call__(self, replayed: Message) -> None:
        """Compare a message of the replay with the next one of the log."""
        if isinstance(replayed, State):
            self._step, self._time_ns = replayed.step, replayed.time_ns
        logged = self._next
        if logged is None:
            raise LogEnded
        found = difference(logged, replayed, rounded=isinstance(replayed, self._rounded))
        if found is not None:
            topic = BY_KIND[type(logged)].name
            raise self.diverged(topic, found.component, found.logged, found.replayed, rounding=found.rounding)
        self.compared[BY_KIND[type(logged)].name] += 1
        self._next = next(self._logged, None)

    @property
    def upcoming(self) -> Message | None:
        """The next message of the log, not yet compared."""
        return self._next

    @property
    def step(self) -> int:
        """The control step under way."""
        return self._step

    def diverged(self, topic: str, component: str, logged: str, replayed: str, *, rounding: bool = False) -> Diverged:
        """Return the error that says where the two part: here."""
        where = Divergence(self._step, self._time_ns, topic, component, logged, replayed)
        return Diverged(where, rounding=rounding)


class AuditedPolicy:
    """The log's policy, which hands out the logged actions after computing each again.

    So the physics is driven by what was done, and what the network says is checked beside it: bit for bit on the
    processor that flew, and within ACTION_TOLERANCE on another, whose float kernels may differ.
    """

    def __init__(self, policy: LoadedPolicy, witness: Witness, *, bitwise: bool) -> None:
        """Audit `policy` against `witness`."""
        self._policy = policy
        self._witness = witness
        self._bitwise = bitwise
        self.robot = policy.robot
        self.observation_layout = policy.observation_layout
        self.reward_weights = policy.reward_weights
        self.largest_difference = 0.0

    def act(self, observation: FloatArray) -> FloatArray:
        """Return the logged action (1, nu) for the observation (1, k) of the step under way."""
        computed = self._policy.act(observation)
        logged = self._witness.upcoming
        if not isinstance(logged, Action | GroundControl) or logged.commanded.shape != computed[0].shape:
            return computed  # the comparison that follows says what is wrong
        for i in self._unlike(logged.commanded, computed[0]):
            texts = (repr(float(logged.commanded[i])), repr(float(computed[0, i])))
            raise self._witness.diverged("/action", f"commanded[{i}]", *texts)
        return logged.commanded[np.newaxis].copy()

    def _unlike(self, logged: FloatArray, computed: FloatArray) -> list[int]:
        """Return where two actions (nu,) differ by more than they may."""
        if self._bitwise:
            return different_bits(logged, computed)
        gap = np.abs(computed - logged)
        self.largest_difference = max(self.largest_difference, float(gap.max()))
        return [int(at) for at in np.flatnonzero(~(gap <= ACTION_TOLERANCE))]
