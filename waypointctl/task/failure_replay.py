"""Failure replay: recently failed courses are drawn again; each robot keeps its own list."""

from __future__ import annotations

from typing import Annotated, Any, Final, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from waypointctl.mission.file_model import FileModel
from waypointctl.seeding import restore_streams, stream, streams_words
from waypointctl.task.progress import CourseProgress

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_NEW: Final = -1  # a course just drawn
_NOT_MINE: Final = -2  # none to keep: it was given, or its episode has ended


class FailureReplay(FileModel):
    """How often a new episode repeats a course that ended in a fall or at its deadline."""

    probability: Annotated[float, Strict(), Field(ge=0, le=1)] = Field(
        0.0,
        description="of an episode to repeat a failed course, if the robot has one; the success rate during training "
        "includes these episodes",
    )
    memory: Annotated[int, Strict(), Field(gt=0, le=256)] = Field(
        8, description="how many failed courses a robot keeps, the latest"
    )
    tries: Annotated[int, Strict(), Field(gt=0, le=65_536)] = Field(
        5, description="how often a failed course is repeated at most; after a success it is removed at once"
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
    """The failed courses of n robots.

    Robot i decides with stream(seed, "retry", i) and keeps only its own failures, so that it does not depend
    on the others. The course is repeated; its start is drawn anew.

    Attributes:
        streams: of each robot.
        waypoints: (n, memory, m, 2) in the world frame [m], the oldest course first.
        count: (n, memory) waypoints of each course.
        tries: (n, memory) how often each was repeated without success.
        size: (n,) courses kept.
        current: (n,) which of them is the current one; negative: none.
    """

    def __init__(self, replay: FailureReplay, num_robots: int, max_waypoints: int, seed: int) -> None:
        """Begin with no failed courses."""
        self.replay = replay
        self.streams = [stream(seed, "retry", i) for i in range(num_robots)]
        self.waypoints: FloatArray = np.zeros((num_robots, replay.memory, max_waypoints, 2))
        self.count: IntArray = np.ones((num_robots, replay.memory), np.int64)
        self.tries: IntArray = np.zeros((num_robots, replay.memory), np.int64)
        self.size: IntArray = np.zeros(num_robots, np.int64)
        self.current: IntArray = np.full(num_robots, _NOT_MINE)

    def choose(self, robot: int) -> FloatArray | None:
        """Return the failed course (m, 2) [m] for a robot's next episode, or None for a new one."""
        rng, size = self.streams[robot], int(self.size[robot])
        again = rng.random() < self.replay.probability and size > 0
        self.current[robot] = slot = int(rng.integers(size)) if again else _NEW
        return self.waypoints[robot, slot, : self.count[robot, slot]].copy() if again else None

    def given(self, robot: int) -> None:
        """Note that a robot's course was given, not drawn: it is not kept if it fails."""
        self.current[robot] = _NOT_MINE

    def ended(self, robots: NDArray[np.intp], success: NDArray[np.bool_], progress: CourseProgress) -> None:
        """Remember or forget the courses of robots (e,) whose episodes ended, in success (e,) or not."""
        for robot, succeeded in zip(robots, success, strict=True):
            slot = self.current[robot]
            # Without autoreset an ended robot is reported in every step; an episode counts once.
            self.current[robot] = _NOT_MINE
            if slot == _NEW and not succeeded:
                self._remember(robot, progress.waypoints[robot, : progress.count[robot]])
            elif slot >= 0:
                self.tries[robot, slot] += 1
                if succeeded or self.tries[robot, slot] >= self.replay.tries:
                    self._forget(robot, slot)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return all arrays needed to continue bit for bit, by name."""
        return {**self._arrays(), "streams": streams_words(self.streams)}

    def restore(self, arrays: dict[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned.

        Raises:
            KeyError, ValueError: it is of other robots, or of another size of memory.
        """
        for name, array in self._arrays().items():
            array[:] = arrays[name]
        restore_streams(self.streams, arrays["streams"])

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
