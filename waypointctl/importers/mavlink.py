"""MAVLink's mission commands that are followed; mavlink_commands.yaml has the others, with what happens to them.

What they and their seven parameters mean: https://mavlink.io/en/messages/common.html#mav_commands, and ArduPilot's own:
https://mavlink.io/en/messages/ardupilotmega.html.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Final

from waypointctl.mission.yaml_tree import read_tree

GLOBAL_FRAMES: Final = (0, 3, 5, 6, 10, 11)  # MAV_FRAMEs with latitude and longitude

WAYPOINT: Final = 16
LOITER_UNLIMITED: Final = 17
LOITER_TURNS: Final = 18
LOITER_TIME: Final = 19
RETURN: Final = 20
LAND: Final = 21
TAKEOFF: Final = 22
LOITER_TO_ALTITUDE: Final = 31
SPLINE: Final = 82
VTOL_TAKEOFF: Final = 84
VTOL_LAND: Final = 85
DELAY: Final = 93
PAYLOAD_PLACE: Final = 94
JUMP: Final = 177
SHOOT: Final = 203
TAG: Final = 600
JUMP_TO_TAG: Final = 601
PICTURE: Final = 2000

FOLLOWED: Final = {
    WAYPOINT: "waypoint",
    LOITER_UNLIMITED: "loiter without end",
    LOITER_TURNS: "loiter turns",
    LOITER_TIME: "loiter",
    RETURN: "return",
    LAND: "landing",
    TAKEOFF: "takeoff",
    LOITER_TO_ALTITUDE: "loiter to altitude",
    SPLINE: "spline waypoint",
    VTOL_TAKEOFF: "VTOL takeoff",
    VTOL_LAND: "VTOL landing",
    DELAY: "delay",
    PAYLOAD_PLACE: "payload placement",
    JUMP: "jump",
    SHOOT: "camera control",
    TAG: "tag",
    JUMP_TO_TAG: "jump to a tag",
    PICTURE: "picture",
}
TAKEOFFS: Final = (TAKEOFF, VTOL_TAKEOFF)
LANDINGS: Final = (LAND, VTOL_LAND)
HOLDS: Final = (WAYPOINT, SPLINE, LOITER_TIME, DELAY)  # their first parameter is a time [s]
ENDS: Final = (RETURN, LOITER_UNLIMITED)  # what follows them is never reached
JUMPS: Final = (JUMP, JUMP_TO_TAG)
# Those that may be without a place: then they are about where the vehicle is.
HERE: Final = (LOITER_UNLIMITED, LOITER_TURNS, LOITER_TIME, LOITER_TO_ALTITUDE, PAYLOAD_PLACE, *TAKEOFFS, *LANDINGS)

# What is not done of those that are followed.
NOT_DONE: Final = {
    TAKEOFF: "the robot stays on the ground",
    VTOL_TAKEOFF: "the robot stays on the ground",
    LAND: "the robot stops at its place",
    VTOL_LAND: "the robot stops at its place",
    LOITER_TURNS: "the robot goes to the centre and makes no turns",
    LOITER_TO_ALTITUDE: "the robot goes to the centre and stays on the ground",
    LOITER_UNLIMITED: "the mission ends at its place",
    SPLINE: "the robot goes straight to it",
    PAYLOAD_PLACE: "the robot goes to its place and carries nothing",
}


@dataclass(frozen=True, slots=True)
class OtherCommand:
    """A command that is not followed."""

    name: str  # MAVLink's
    is_left_out: bool  # whether it changes neither the path nor the time at a waypoint; any other is refused
    reason: str  # why, or what to do instead


@cache
def other_commands() -> Mapping[int, OtherCommand]:
    """Return the commands of mavlink_commands.yaml by their numbers."""
    groups = read_tree((files("waypointctl.importers") / "mavlink_commands.yaml").read_bytes()).data
    return {
        int(number): OtherCommand(name, "left_out" in group, group.get("left_out") or group["refused"])
        for group in groups
        for number, name in group["commands"].items()
    }
