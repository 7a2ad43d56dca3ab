"""The executive's state machine: every mode, every signal, and the only way from one to the other.

docs/executive.md is drawn from this table by `python docs/executive.py`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import Final

from waypointctl.log.messages import Mode


class Signal(StrEnum):
    """What can make the executive change its mode."""

    START_LEG = "start_leg"  # a leg begins
    AWAIT_RELEASE = "await_release"  # the next waypoint is not released
    START_HOLD = "start_hold"  # a waypoint with a hold time is reached
    START_OBSERVATION = "start_observation"  # a waypoint with an observation is reached, or its hold is over
    PAUSE = "pause"  # a hold is commanded
    SAFE_HOLD = "safe_hold"  # a rule on board stops the robot
    RESUME_LEG = "resume_leg"  # the leg that was interrupted continues
    RESUME_HOLD = "resume_hold"  # the hold that was interrupted continues
    RESUME_OBSERVATION = "resume_observation"  # the observation that was interrupted continues
    RESUME_RETURN = "resume_return"  # the way home that was interrupted continues
    GO_HOME = "go_home"  # a command or a rule starts the return home
    COMPLETE = "complete"  # the plan, or the return home, is over
    FAIL = "fail"  # the plan, or the return home, has failed
    TELEOPERATE = "teleoperate"  # an action arrives from the ground
    CLEAR = "clear"  # no command is left: cancelled, expired or aborted
    FALL = "fall"  # the robot has fallen


UPRIGHT: Final = frozenset(Mode) - {Mode.FALLEN}
UNDER_WAY: Final = frozenset({Mode.NAVIGATING, Mode.HOLDING, Mode.OBSERVING, Mode.WAITING, Mode.RETURNING})
AT_REST: Final = frozenset({Mode.IDLE, Mode.DONE, Mode.FAILED})  # nothing is under way
SUSPENDED: Final = frozenset({Mode.PAUSED, Mode.SAFE})  # what was under way can be resumed
POLICY_MODES: Final = frozenset({Mode.NAVIGATING, Mode.RETURNING})  # the policy has the motors
BUSY: Final = POLICY_MODES | {
    Mode.HOLDING,
    Mode.OBSERVING,
    Mode.TELEOPERATED,
}  # it comes to an end, or is led on, by itself
RESUME_SIGNALS: Final = {  # what takes up again what was under way; the rest begins afresh
    Mode.NAVIGATING: Signal.RESUME_LEG,
    Mode.HOLDING: Signal.RESUME_HOLD,
    Mode.OBSERVING: Signal.RESUME_OBSERVATION,
    Mode.RETURNING: Signal.RESUME_RETURN,
}


def _table(*rules: tuple[Signal, Iterable[Mode], Mode]) -> Mapping[tuple[Mode, Signal], Mode]:
    return MappingProxyType({(mode, signal): after for signal, modes, after in rules for mode in modes})


TRANSITIONS: Final = _table(
    (Signal.START_LEG, UPRIGHT, Mode.NAVIGATING),
    (Signal.AWAIT_RELEASE, UPRIGHT, Mode.WAITING),
    (Signal.START_HOLD, {Mode.NAVIGATING}, Mode.HOLDING),
    (Signal.START_OBSERVATION, {Mode.NAVIGATING, Mode.HOLDING}, Mode.OBSERVING),
    (Signal.PAUSE, UNDER_WAY | {Mode.SAFE}, Mode.PAUSED),
    (Signal.SAFE_HOLD, UNDER_WAY | {Mode.TELEOPERATED}, Mode.SAFE),
    (Signal.RESUME_LEG, SUSPENDED, Mode.NAVIGATING),
    (Signal.RESUME_HOLD, SUSPENDED, Mode.HOLDING),
    (Signal.RESUME_OBSERVATION, SUSPENDED, Mode.OBSERVING),
    (Signal.RESUME_RETURN, SUSPENDED, Mode.RETURNING),
    (Signal.GO_HOME, UPRIGHT, Mode.RETURNING),
    (Signal.COMPLETE, UNDER_WAY | SUSPENDED, Mode.DONE),
    (Signal.FAIL, POLICY_MODES, Mode.FAILED),
    (Signal.TELEOPERATE, AT_REST, Mode.TELEOPERATED),
    (Signal.CLEAR, UPRIGHT, Mode.IDLE),
    (Signal.FALL, UPRIGHT, Mode.FALLEN),
)


@dataclass(slots=True)
class StateMachine:
    """The mode the robot is in."""

    _mode: Mode = Mode.IDLE

    @property
    def mode(self) -> Mode:
        """The mode; `signal` alone changes it."""
        return self._mode

    def signal(self, signal: Signal) -> None:
        """Change the mode as the table says.

        Raises:
            RuntimeError: the table has no such transition. That is a bug: no command and no world may cause it.
        """
        after = TRANSITIONS.get((self._mode, signal))
        if after is None:
            raise RuntimeError(f"the executive has no transition for {signal} while {self._mode}")
        self._mode = after
