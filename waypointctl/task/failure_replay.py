"""Failure replay: courses that failed lately are repeated; each robot remembers its own."""

from __future__ import annotations

from typing import Annotated, Any, Final, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from waypointctl.mission.file_model import FileModel
from waypointctl.seeding import restore_stream, stream, stream_words
from waypointctl.task.progress import CourseProgress

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_NEW: Final = -1  # a course just drawn
_NOT_MINE: Final = -2  # none that may be remembered: it was given, or its episode has ended


class FailureReplay(FileModel):
    """How often a new episode repeats a course that failed: by a fall or by its deadline."""

    probability: Annotated[float, Strict(), Field(ge=0, le=1)] = Field(
        0.0,
        description="that an episode repeats a failed course, if one is remembered; the success that training shows "
        "counts these, too",
    )
    memory: Annotated[int, Strict(), Field(gt=0, le=256)] = Field(
        8, description="failed courses that a robot remembers, its latest"
    )
    tries: Annotated[int, Strict(), Field(gt=0, le=65_536)] = Field(
        5, description="how often a failed course is repeated before it is forgotten; after a success, at once"
    )

    @model_validator(mode="after")
    def _has_a_probability(self) -> Self:
        unused = sorted(self.model_fields_set & {"memory", "tries"})
        if unused and not self.probability:
            error = PydanticCustomError("failure_replay", "needs a 'probability' above 0, such as probability: 0.3")
            raise ValidationError.from_exception_data(
                "failure_replay", [InitErrorDetails(type=error, loc=(name,), input=None) for name in unused]
            )
        return self


class FailedCourses:
    """What n robots remember of the courses they failed.

    Robot i decides with stream(seed, "retry", i) and remembers its own failures alone, so that it goes as it would
    without the others. A course is repeated, not its start: that is drawn anew.

    Attributes:
        streams: of each robot.
        waypoints: (n, memory, m, 2) in the world frame [m], the oldest course first.
        count: (n, memory) waypoints of each course.
        tries: (n, memory) how often each was tried again, in vain.
        size: (n,) courses remembered.
        walking: (n,) which of them is being walked; negative: none.
    """

    def __init__(self, replay: FailureReplay, num_robots: int, max_waypoints: int, seed: int) -> None:
        """Remember nothing yet."""
        self.replay = replay
        self.streams = [stream(seed, "retry", i) for i in range(num_robots)]
        self.waypoints: FloatArray = np.zeros((num_robots, replay.memory, max_waypoints, 2))
        self.count: IntArray = np.ones((num_robots, replay.memory), np.int64)
        self.tries: IntArray = np.zeros((num_robots, replay.memory), np.int64)
        self.size: IntArray = np.zeros(num_robots, np.int64)
        self.walking: IntArray = np.full(num_robots, _NOT_MINE)

    def choose(self, robot: int) -> FloatArray | None:
        """Return the failed course (m, 2) [m] that a robot is to walk now, or None for a new one."""
        rng, size = self.streams[robot], int(self.size[robot])
        again = rng.random() < self.replay.probability and size > 0
        self.walking[robot] = slot = int(rng.integers(size)) if again else _NEW
        return self.waypoints[robot, slot, : self.count[robot, slot]].copy() if again else None

    def given(self, robot: int) -> None:
        """Take note that a robot walks a course that was not drawn: however it ends, it is not remembered."""
        self.walking[robot] = _NOT_MINE

    def ended(self, robots: NDArray[np.intp], success: NDArray[np.bool_], progress: CourseProgress) -> None:
        """Remember or forget the courses of robots (e,) whose episodes ended, in success (e,) or not."""
        for robot, walked in zip(robots, success, strict=True):
            slot = self.walking[robot]
            # Who is left to walk on ends in every step; an episode counts once.
            self.walking[robot] = _NOT_MINE
            if slot == _NEW and not walked:
                self._remember(robot, progress.waypoints[robot, : progress.count[robot]])
            elif slot >= 0:
                self.tries[robot, slot] += 1
                if walked or self.tries[robot, slot] >= self.replay.tries:
                    self._forget(robot, slot)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return all that going on bit for bit needs, by name."""
        return {**self._arrays(), "streams": np.stack([stream_words(rng) for rng in self.streams])}

    def restore(self, arrays: dict[str, NDArray[Any]]) -> None:
        """Go on from what `state` returned.

        Raises:
            KeyError, ValueError: it is of other robots, or of another size of memory.
        """
        for name, array in self._arrays().items():
            array[:] = arrays[name]
        for rng, words in zip(self.streams, arrays["streams"], strict=True):
            restore_stream(rng, words)

    def _arrays(self) -> dict[str, NDArray[Any]]:
        return {name: value for name, value in vars(self).items() if isinstance(value, np.ndarray)}

    def _remember(self, robot: int, course: FloatArray) -> None:
        if self.size[robot] == self.replay.memory:
            self._forget(robot, 0)
        slot = self.size[robot]
        self.waypoints[robot, slot, : len(course)] = course
        self.count[robot, slot] = len(course)
        self.tries[robot, slot] = 0
        self.size[robot] += 1

    def _forget(self, robot: int, slot: int) -> None:
        for of_courses in (self.waypoints[robot], self.count[robot], self.tries[robot]):
            of_courses[slot:-1] = of_courses[slot + 1 :].copy()
        self.size[robot] -= 1
