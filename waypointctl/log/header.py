"""The header of a log: all that comes before its first message."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Protocol

from waypointctl import __version__
from waypointctl.log.messages import FloatArray, PlannedWaypoint
from waypointctl.log.setting import MissionSetting
from waypointctl.sim.geometry import Geom

SCHEMA_VERSION: Final = 2  # of topics, schemas and metadata; a log of another one is refused
METADATA_NAME: Final = "waypointctl"  # of the MCAP metadata record; a log without it is not ours
LIBRARY: Final = f"waypointctl {__version__}"  # of the MCAP header
LAYOUT_NAME: Final = "foxglove-layout.json"
_NO_SETTING: Final = MissionSetting()


@dataclass(frozen=True, slots=True)
class Attachment:
    """A file that travels in the log."""

    name: str
    media_type: str
    data: bytes


@dataclass(frozen=True, slots=True)
class LogHeader:
    """What the caller gives a new log.

    The writer adds the Foxglove layout to the attachments, and schema_version and robot to the metadata.
    """

    robot: str
    kinematics: Kinematics
    waypoints: tuple[PlannedWaypoint, ...]  # the mission's, drawn from the start
    attachments: tuple[Attachment, ...]
    metadata: Mapping[str, str]
    setting: MissionSetting = _NO_SETTING  # drawn from the start, too
    library: str = LIBRARY


class Kinematics(Protocol):
    """Where a robot's bodies are. Its root is a free joint: qpos and qvel begin with its 7 and 6 numbers."""

    @property
    def body_names(self) -> tuple[str, ...]:
        """The robot's bodies, the root first, without the world."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The hinge and slide joints, in the order of qpos[7:] and qvel[6:]."""

    @property
    def geoms(self) -> tuple[Geom, ...]:
        """What is to be drawn."""

    def poses(self, qpos: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the bodies' positions (nbody, 3) [m] and quaternions (nbody, 4) w x y z in the world at qpos (nq,)."""
