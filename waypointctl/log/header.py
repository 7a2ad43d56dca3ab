"""What a log says before its first message."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from waypointctl import __version__
from waypointctl.log.kinematics import Kinematics
from waypointctl.log.messages import PlannedWaypoint
from waypointctl.log.setting import MissionSetting

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
