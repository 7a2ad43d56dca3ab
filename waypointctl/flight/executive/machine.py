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

    SET_OUT = "set_out"  # a leg begins
    WITHHELD = "withheld"  # the next waypoint is not released
    HOLD_BEGUN = "hold_begun"  # a waypoint is reached that has a hold time
    OBSERVATION_BEGUN = "observation_begun"  # a waypoint is reached, or its hold over, that is to be observed
    PAUSE = "pause"  # a hold is commanded
    SECURE = "secure"  # a rule wants it to stand
    WALK_ON = "walk_on"  # the leg that was interrupted goes on
    HOLD_ON = "hold_on"  # the hold that was interrupted goes on
    OBSERVE_ON = "observe_on"  # the observation that was interrupted goes on
    RETURN_ON = "return_on"  # the way home that was interrupted goes on
    GO_HOME = "go_home"  # a command or a rule sends it home
    FINISH = "finish"  # the plan, or the way home, is over
    GIVE_UP = "give_up"  # the plan, or the way home, has failed
    STEER = "steer"  # an action arrives from the ground
    DROP = "drop"  # nothing is left to do: cancelled, expired or aborted
    FALL = "fall"  # the robot lies


UPRIGHT: Final = frozenset(Mode) - {Mode.FALLEN}
UNDER_WAY: Final = frozenset({Mode.NAVIGATING, Mode.HOLDING, Mode.OBSERVING, Mode.WAITING, Mode.RETURNING})
AT_REST: Final = frozenset({Mode.IDLE, Mode.DONE, Mode.FAILED})  # nothing is under way
SUSPENDED: Final = frozenset({Mode.PAUSED, Mode.SAFE})  # what was under way may go on
ON_FOOT: Final = frozenset({Mode.NAVIGATING, Mode.RETURNING})  # the policy has the motors
BUSY: Final = ON_FOOT | {Mode.HOLDING, Mode.OBSERVING, Mode.TELEOPERATED}  # it comes to an end, or is led on, by itself
ON_AGAIN: Final = {  # what takes up again what was under way; the rest begins afresh
    Mode.NAVIGATING: Signal.WALK_ON,
    Mode.HOLDING: Signal.HOLD_ON,
    Mode.OBSERVING: Signal.OBSERVE_ON,
    Mode.RETURNING: Signal.RETURN_ON,
}


def _table(*rules: tuple[Signal, Iterable[Mode], Mode]) -> Mapping[tuple[Mode, Signal], Mode]:
    return MappingProxyType({(mode, signal): after for signal, modes, after in rules for mode in modes})


TRANSITIONS: Final = _table(
    (Signal.SET_OUT, UPRIGHT, Mode.NAVIGATING),
    (Signal.WITHHELD, UPRIGHT, Mode.WAITING),
    (Signal.HOLD_BEGUN, {Mode.NAVIGATING}, Mode.HOLDING),
    (Signal.OBSERVATION_BEGUN, {Mode.NAVIGATING, Mode.HOLDING}, Mode.OBSERVING),
    (Signal.PAUSE, UNDER_WAY | {Mode.SAFE}, Mode.PAUSED),
    (Signal.SECURE, UNDER_WAY | {Mode.TELEOPERATED}, Mode.SAFE),
    (Signal.WALK_ON, SUSPENDED, Mode.NAVIGATING),
    (Signal.HOLD_ON, SUSPENDED, Mode.HOLDING),
    (Signal.OBSERVE_ON, SUSPENDED, Mode.OBSERVING),
    (Signal.RETURN_ON, SUSPENDED, Mode.RETURNING),
    (Signal.GO_HOME, UPRIGHT, Mode.RETURNING),
    (Signal.FINISH, UNDER_WAY | SUSPENDED, Mode.DONE),
    (Signal.GIVE_UP, ON_FOOT, Mode.FAILED),
    (Signal.STEER, AT_REST, Mode.TELEOPERATED),
    (Signal.DROP, UPRIGHT, Mode.IDLE),
    (Signal.FALL, UPRIGHT, Mode.FALLEN),
)


@dataclass(slots=True)
class Machine:
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
