"""MAVLink's mission commands: those that a walking robot follows, and those that change nothing about where it walks.

What they and their seven parameters mean: https://mavlink.io/en/messages/common.html#mav_commands.
"""

from __future__ import annotations

from typing import Final

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
SHOOT: Final = 203
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
    SHOOT: "camera control",
    PICTURE: "picture",
}
TAKEOFFS: Final = (TAKEOFF, VTOL_TAKEOFF)
LANDINGS: Final = (LAND, VTOL_LAND)
LAST: Final = (RETURN, *LANDINGS, LOITER_UNLIMITED)

# What is not done of those that are followed.
NOT_DONE: Final = {
    TAKEOFF: "the robot walks from where it stands",
    VTOL_TAKEOFF: "the robot walks from where it stands",
    LAND: "the robot ends at its place, on foot",
    VTOL_LAND: "the robot ends at its place, on foot",
    LOITER_TURNS: "the robot walks to the centre and makes no turns",
    LOITER_TO_ALTITUDE: "the robot walks to the centre and stays on the ground",
    LOITER_UNLIMITED: "the mission ends at its place",
    SPLINE: "the robot walks straight to it",
}

_SPEED: Final = "the policy walks at its own speed"
_FACING: Final = "where it faces is the policy's own"
_CAMERA: Final = "the camera takes one picture at a time, at a waypoint"
_GIMBAL: Final = "there is no gimbal to point"
_GROUND: Final = "the robot stays on the ground"
_WAIT: Final = "nothing that is left in waits for it"
_DEVICE: Final = "there is no such device"
_MARK: Final = "the mission is walked from its start"

# Number: MAVLink's name, and why it is left out. None of them changes where the robot walks or for how long it stands.
LEFT_OUT: Final = {
    30: ("NAV_CONTINUE_AND_CHANGE_ALT", _GROUND),
    80: ("NAV_ROI", _GIMBAL),
    112: ("CONDITION_DELAY", _WAIT),
    113: ("CONDITION_CHANGE_ALT", _GROUND),
    114: ("CONDITION_DISTANCE", _WAIT),
    115: ("CONDITION_YAW", _FACING),
    178: ("DO_CHANGE_SPEED", _SPEED),
    181: ("DO_SET_RELAY", _DEVICE),
    182: ("DO_REPEAT_RELAY", _DEVICE),
    183: ("DO_SET_SERVO", _DEVICE),
    184: ("DO_REPEAT_SERVO", _DEVICE),
    186: ("DO_CHANGE_ALTITUDE", _GROUND),
    187: ("DO_SET_ACTUATOR", _DEVICE),
    188: ("DO_RETURN_PATH_START", _MARK),
    189: ("DO_LAND_START", _MARK),
    194: ("DO_SET_REVERSE", _FACING),
    195: ("DO_SET_ROI_LOCATION", _GIMBAL),
    196: ("DO_SET_ROI_WPNEXT_OFFSET", _GIMBAL),
    197: ("DO_SET_ROI_NONE", _GIMBAL),
    198: ("DO_SET_ROI_SYSID", _GIMBAL),
    200: ("DO_CONTROL_VIDEO", _CAMERA),
    201: ("DO_SET_ROI", _GIMBAL),
    202: ("DO_DIGICAM_CONFIGURE", _CAMERA),
    204: ("DO_MOUNT_CONFIGURE", _GIMBAL),
    205: ("DO_MOUNT_CONTROL", _GIMBAL),
    206: ("DO_SET_CAM_TRIGG_DIST", _CAMERA),
    207: ("DO_FENCE_ENABLE", "the fence holds all the time"),
    208: ("DO_PARACHUTE", _DEVICE),
    211: ("DO_GRIPPER", _DEVICE),
    212: ("DO_AUTOTUNE_ENABLE", _DEVICE),
    214: ("DO_SET_CAM_TRIGG_INTERVAL", _CAMERA),
    220: ("DO_MOUNT_CONTROL_QUAT", _GIMBAL),
    223: ("DO_ENGINE_CONTROL", _DEVICE),
    530: ("SET_CAMERA_MODE", _CAMERA),
    531: ("SET_CAMERA_ZOOM", _CAMERA),
    532: ("SET_CAMERA_FOCUS", _CAMERA),
    534: ("SET_CAMERA_SOURCE", _CAMERA),
    1000: ("DO_GIMBAL_MANAGER_PITCHYAW", _GIMBAL),
    1001: ("DO_GIMBAL_MANAGER_CONFIGURE", _GIMBAL),
    2001: ("IMAGE_STOP_CAPTURE", _CAMERA),
    2003: ("DO_TRIGGER_CONTROL", _CAMERA),
    2500: ("VIDEO_START_CAPTURE", _CAMERA),
    2501: ("VIDEO_STOP_CAPTURE", _CAMERA),
    3000: ("DO_VTOL_TRANSITION", _GROUND),
}

# Those that change the way, and what to do instead.
INSTEAD: Final = {
    177: "DO_JUMP; the mission's 'repeat' walks all of it again",
    179: "DO_SET_HOME; the home is where the robot starts, or the mission's onboard.home",
    600: "JUMP_TAG; the mission's 'repeat' walks all of it again",
    601: "DO_JUMP_TAG; the mission's 'repeat' walks all of it again",
}
