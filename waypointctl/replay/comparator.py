"""The logged flight as the comparator of its replay: each message is compared as it is made again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.header import PolicyNotInLog
from waypointctl.log.messages import Action, Checkpoint, GroundControl, Message, Observation, State, Telemetry
from waypointctl.log.reader import EncodedMessage
from waypointctl.policy.protocol import Policy, PolicyState, state_from
from waypointctl.replay.difference import difference, different_bits
from waypointctl.replay.verdict import Divergence

FloatArray = NDArray[np.float64]

# Another processor may sum a network's float32 products in another order. The shipped networks then differ by some
# 1e-6, as they do from themselves in float64. Absolute, and relative for actions above 1.
ACTION_TOLERANCE: Final = 1e-5


class Diverged(Exception):
    """The replay has parted from the log; `rounding` says that another way of rounding may be why."""

    def __init__(self, where: Divergence, *, rounding: bool = False) -> None:
        """Say where."""
        self.where = where
        self.rounding = rounding
        super().__init__(where.component)


class LogEnded(Exception):
    """The log holds no more: it was cut short."""


class LogComparator:
    """Takes the replay's messages, with the logged ones to hold them against.

    What is computed with numpy's trigonometry, observations and telemetry, may be rounded otherwise on another
    processor. States never may: physics goes on from them.

    Most messages are the same bytes as those of the log, which is seen without decoding them.

    Attributes:
        compared: how many messages of each topic were found equal.
        rounded: how many of them only within rounding.
    """

    def __init__(self, logged: Iterator[EncodedMessage], *, bitwise: bool) -> None:
        """Take the logged messages in their order; without `bitwise` let numpy round otherwise."""
        self._logged = logged
        self._rounded = () if bitwise else (Observation, Telemetry, GroundControl)
        self._next = next(logged, None)
        self._opened: Message | None = None  # the next one, once it has been asked for
        self._step = 0
        self._time_ns = 0
        self.compared: Counter[str] = Counter()
        self.rounded: Counter[str] = Counter()

    def __call__(self, replayed: Message) -> Message:
        """Compare a message of the replay with the next one of the log, and return that one."""
        if isinstance(replayed, State):
            self._step, self._time_ns = replayed.step, replayed.time_ns
        sealed = self._next
        if sealed is None:
            raise LogEnded
        logged = replayed if sealed.matches(replayed) else self._equal(sealed, replayed)
        self.compared[sealed.topic.name] += 1
        self._next, self._opened = next(self._logged, None), None
        return logged

    @property
    def has_ended(self) -> bool:
        """Whether every message of the log has been compared."""
        return self._next is None

    @property
    def upcoming_kind(self) -> type[Message] | None:
        """What kind of message comes next in the log."""
        return None if self._next is None else self._next.topic.kind

    @property
    def upcoming(self) -> Message | None:
        """The next message of the log, not yet compared."""
        if self._opened is None and self._next is not None:
            self._opened = self._next.message()
        return self._opened

    @property
    def step(self) -> int:
        """The control step under way."""
        return self._step

    def _equal(self, sealed: EncodedMessage, replayed: Message) -> Message:
        logged, topic = sealed.message(), sealed.topic.name
        found = difference(logged, replayed)
        if found is not None:
            if found.rounding and isinstance(replayed, self._rounded):
                found = difference(logged, replayed, rounded=True)
                self.rounded[topic] += 1
            if found is not None:
                raise self.diverged(topic, found.component, found.logged, found.replayed, rounding=found.rounding)
        return logged

    def diverged(self, topic: str, component: str, logged: str, replayed: str, *, rounding: bool = False) -> Diverged:
        """Return the error that says where the two part: here."""
        where = Divergence(self._step, self._time_ns, topic, component, logged, replayed)
        return Diverged(where, rounding=rounding)


class RecordedPolicy(Policy):
    """Drives a replay with the logged actions, and compares each with that of the log's own policy, where it has one.

    So the physics is driven by what was done, and what the network computes is checked beside it: bit for bit on the
    processor that flew, and within ACTION_TOLERANCE on another, whose float kernels may differ.

    Attributes:
        rounded: how many actions were the same only within ACTION_TOLERANCE.
    """

    def __init__(self, policy: Policy, comparator: LogComparator, *, bitwise: bool) -> None:
        """Compare the actions of `policy` with those in `comparator`."""
        self._policy = policy
        self._comparator = comparator
        self._bitwise = bitwise
        self.rounded = 0

    @property
    def name(self) -> str:
        """What the policy is called."""
        return self._policy.name

    @property
    def robot(self) -> str:
        """The robot that the policy was made for."""
        return self._policy.robot

    @property
    def observation_layout(self) -> str:
        """The policy's observation layout."""
        return self._policy.observation_layout

    @property
    def reward_weights(self) -> Mapping[str, float]:
        """The policy's reward weights."""
        return self._policy.reward_weights

    def reset(self, mask: NDArray[np.bool_]) -> None:
        """Begin a new episode."""
        self._policy.reset(mask)

    def state(self) -> PolicyState:
        """Return the policy's state; that of the log's checkpoint, which comes next, where there is no policy."""
        logged = self._comparator.upcoming
        if isinstance(self._policy, PolicyNotInLog) and isinstance(logged, Checkpoint):
            return state_from(logged.policy_state)
        return self._policy.state()

    def act(self, observation: FloatArray) -> FloatArray:
        """Return the logged action (1, nu) for the observation (1, k) of the step under way."""
        computed = self._policy.act(observation)
        logged = self._comparator.upcoming if self._comparator.upcoming_kind in (Action, GroundControl) else None
        if not isinstance(logged, Action | GroundControl) or logged.commanded.shape != computed[0].shape:
            return computed  # the comparison that follows says what is wrong
        if isinstance(self._policy, PolicyNotInLog):
            return logged.commanded[np.newaxis].copy()
        for i in self._unlike(logged.commanded, computed[0]):
            texts = (repr(float(logged.commanded[i])), repr(float(computed[0, i])))
            raise self._comparator.diverged("/action", f"commanded[{i}]", *texts)
        return logged.commanded[np.newaxis].copy()

    def _unlike(self, logged: FloatArray, computed: FloatArray) -> list[int]:
        """Return where two actions (nu,) differ by more than they may."""
        unlike = different_bits(logged, computed)
        if self._bitwise or not unlike:
            return unlike
        self.rounded += 1
        near = np.abs(computed - logged) <= ACTION_TOLERANCE * np.maximum(1.0, np.abs(logged))
        return [int(at) for at in np.flatnonzero(~near)]
