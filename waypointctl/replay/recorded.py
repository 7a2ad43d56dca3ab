"""Policy, camera and console of a flight that is simulated again: each gives what the log has, and checks it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.operator.console import QUIT, request_from
from waypointctl.flight.policy_fit import PolicyNotInLog
from waypointctl.flight.sink import FORMAT, FRAME, OnboardCamera
from waypointctl.log.messages import Action, Checkpoint, ConsoleInput, Event, GroundControl, Picture, State
from waypointctl.log.png import SOFTWARE, texts_of
from waypointctl.log.records import shown
from waypointctl.mission.mission import Mission
from waypointctl.policy.protocol import Policy, PolicyState, state_from
from waypointctl.replay.comparator import LogComparator, different_bits
from waypointctl.replay.summary import FlightSummary


class RecordedCamera:
    """Takes the pictures that the log has: only of the renderer that drew them the same bytes are expected.

    A picture that another renderer drew is checked by its checksums, and handed on as it is. Where the log has none,
    none is drawn now: nothing could draw when it was flown, or they were taken out. Where something can draw, the log
    is then not what is written here.

    Attributes:
        drawn_again: how many pictures were.
        handed_on: how many were drawn by another renderer.
        missing: how many observations the log has no picture of.
    """

    def __init__(self, camera: OnboardCamera, comparator: LogComparator) -> None:
        """Hold `camera` against `comparator`."""
        self.drawn_again = self.handed_on = self.missing = 0
        self._camera = camera
        self._comparator = comparator

    def __call__(self, event: Event, state: State) -> Picture | None:
        """Return what the log should have as the picture of an observation; None where it has none."""
        logged = self._comparator.upcoming if self._comparator.upcoming_kind is Picture else None
        if not isinstance(logged, Picture):
            self.missing += 1
            return None
        try:
            renderer = texts_of(logged.data).get(SOFTWARE, "")
        except ValueError as error:
            raise self._comparator.diverged("/camera", "data", shown(logged.data), str(error)) from error
        if renderer and renderer == self._camera.renderer:
            self.drawn_again += 1
            return self._camera(event, state)
        self.handed_on += 1
        return Picture(event.time_ns, FRAME, FORMAT, logged.data)

    @property
    def checks(self) -> tuple[str, ...]:
        """What was compared of the pictures, a line each."""
        lines = []
        if self.drawn_again:
            lines.append(f"{_pictures(self.drawn_again)}, redrawn byte for byte")
        if self.missing and not self._could_be_there:
            lines.append(self._without)
        return tuple(lines)

    @property
    def not_compared(self) -> tuple[str, ...]:
        """What could not be compared of the pictures, a line each."""
        lines = []
        if self.handed_on:
            lines.append(f"{_pictures(self.handed_on)}: {self._why_not}")
        if self.missing and self._could_be_there:
            lines.append(self._without)
        return tuple(lines)

    @property
    def _could_be_there(self) -> bool:
        """Whether a flight here would take the pictures that the log lacks."""
        return bool(self.drawn_again or self.handed_on or self._camera.renderer)

    @property
    def _without(self) -> str:
        return f"{self.missing} observation{'s' * (self.missing != 1)} without a picture in the log"

    @property
    def _why_not(self) -> str:
        if not self._camera.renderer:
            return f"no renderer here: {self._camera.trouble.splitlines()[0]}"
        return f"another renderer drew {'it' if self.handed_on == 1 else 'them'}"


def _pictures(count: int) -> str:
    return "1 picture" if count == 1 else f"{count} pictures"


FloatArray = NDArray[np.float64]

# Another processor may sum a network's float32 products in another order. The shipped networks then differ by some
# 1e-6, as they do from themselves in float64. Absolute, and relative for actions above 1.
ACTION_TOLERANCE: Final = 1e-5


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
        """The policy's name."""
        return self._policy.name

    @property
    def robot(self) -> str:
        """The robot that the policy was made for."""
        return self._policy.robot

    @property
    def observation_layout(self) -> str | tuple[str, ...]:
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
            return computed  # the comparison that follows reports the difference
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


class RecordedConsole:
    """The console of a replayed flight: each line comes at its logged time.

    Attributes:
        is_open: whether the flight had one.
        has_closed: whether it was closed by now.
    """

    def __init__(self, comparator: LogComparator, mission: Mission, events: FlightSummary) -> None:
        """Take the lines from the log that `comparator` reads; `events` is the summary of its events."""
        self.is_open = events.had_console
        self.has_closed = False
        self._comparator = comparator
        self._mission = mission
        self._interrupted_ns = events.interrupted_ns
        self._now_ns = -1

    def lines(self, now_ns: int) -> Iterator[str]:
        """Yield the lines that were typed at this moment."""
        self._now_ns = now_ns
        while (line := self._upcoming) is not None and line.time_ns == now_ns:
            self.has_closed = self.has_closed or line.text == QUIT
            yield self._understood(line.text)

    def asleep(self, now_ns: int, until_ns: int) -> int:
        """Return when the next line comes, or the flight is interrupted, if that is before `until_ns`."""
        line = self._upcoming
        return min(until_ns, self._interrupted_ns, until_ns if line is None else line.time_ns)

    def interrupted(self) -> bool:
        """Return whether the flight was interrupted by now."""
        return self._now_ns >= self._interrupted_ns

    @property
    def _upcoming(self) -> ConsoleInput | None:
        if self._comparator.upcoming_kind is not ConsoleInput:
            return None
        upcoming = self._comparator.upcoming
        return upcoming if isinstance(upcoming, ConsoleInput) else None

    def _understood(self, text: str) -> str:
        if text != QUIT:
            try:
                request_from(text, self._mission)
            except ValueError as error:
                raise self._comparator.diverged("/console", "text", repr(text), f"not understood: {error}") from error
        return text
