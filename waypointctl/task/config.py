"""All that defines a task, in one record."""

from __future__ import annotations

from dataclasses import dataclass, field

from waypointctl.task.acceptance import Acceptance
from waypointctl.task.cases import Cases
from waypointctl.task.course import Course, Deadline
from waypointctl.task.retry import Retry
from waypointctl.task.reward import RewardWeights
from waypointctl.task.start import Start
from waypointctl.task.variation import Variation


@dataclass(frozen=True, slots=True)
class TaskConfig:
    """A waypoint task: which robot, what it sees, what it is paid, where it is to go, when it is there."""

    robot: str = "ant"
    observation: str = "egocentric"
    reward: RewardWeights = field(default_factory=RewardWeights)
    course: Course | Cases = field(default_factory=Course)
    retry: Retry = field(default_factory=Retry)
    acceptance: Acceptance = field(default_factory=Acceptance)
    deadline: Deadline = field(default_factory=Deadline)
    start: Start = field(default_factory=Start)
    variation: Variation = field(default_factory=Variation)
