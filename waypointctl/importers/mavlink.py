"""MAVLink's mission commands: what a walking robot follows, what does not change its way, and what it cannot follow.

What they and their seven parameters mean: https://mavlink.io/en/messages/common.html#mav_commands, and ArduPilot's own:
https://mavlink.io/en/messages/ardupilotmega.html.
"""

from __future__ import annotations

from typing import Final

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
    LAND: "the robot stops at its place, on foot",
    VTOL_LAND: "the robot stops at its place, on foot",
    LOITER_TURNS: "the robot walks to the centre and makes no turns",
    LOITER_TO_ALTITUDE: "the robot walks to the centre and stays on the ground",
    LOITER_UNLIMITED: "the mission ends at its place",
    SPLINE: "the robot walks straight to it",
    PAYLOAD_PLACE: "the robot walks to its place and carries nothing",
}

_SPEED: Final = "the policy sets the speed"
_FACING: Final = "the policy sets the heading"
_CAMERA: Final = "the camera takes one picture at a time, at a waypoint"
_GIMBAL: Final = "there is no gimbal to point"
_GROUND: Final = "the robot stays on the ground"
_WAIT: Final = "no command that is kept waits for it"
_DEVICE: Final = "there is no such device"
_MARK: Final = "the mission is walked from its start"
_SETTING: Final = "it sets up or asks for what a mission file does not have"

# Number: MAVLink's name, and why it is left out. None of them changes where the robot walks or for how long it stands.
LEFT_OUT: Final = {
    30: ("NAV_CONTINUE_AND_CHANGE_ALT", _GROUND),
    80: ("NAV_ROI", _GIMBAL),
    83: ("NAV_ALTITUDE_WAIT", _GROUND),
    95: ("NAV_LAST", _MARK),
    112: ("CONDITION_DELAY", _WAIT),
    113: ("CONDITION_CHANGE_ALT", _GROUND),
    114: ("CONDITION_DISTANCE", _WAIT),
    115: ("CONDITION_YAW", _FACING),
    159: ("CONDITION_LAST", _MARK),
    178: ("DO_CHANGE_SPEED", _SPEED),
    180: ("DO_SET_PARAMETER", _SETTING),
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
    209: ("DO_MOTOR_TEST", _DEVICE),
    210: ("DO_INVERTED_FLIGHT", _GROUND),
    211: ("DO_GRIPPER", _DEVICE),
    212: ("DO_AUTOTUNE_ENABLE", _DEVICE),
    214: ("DO_SET_CAM_TRIGG_INTERVAL", _CAMERA),
    215: ("DO_SET_RESUME_REPEAT_DIST", _MARK),
    216: ("DO_SPRAYER", _DEVICE),
    217: ("DO_SEND_SCRIPT_MESSAGE", _DEVICE),
    218: ("DO_AUX_FUNCTION", _DEVICE),
    220: ("DO_MOUNT_CONTROL_QUAT", _GIMBAL),
    221: ("DO_GUIDED_MASTER", _SETTING),
    223: ("DO_ENGINE_CONTROL", _DEVICE),
    240: ("DO_LAST", _MARK),
    241: ("PREFLIGHT_CALIBRATION", _SETTING),
    242: ("PREFLIGHT_SET_SENSOR_OFFSETS", _SETTING),
    243: ("PREFLIGHT_UAVCAN", _SETTING),
    245: ("PREFLIGHT_STORAGE", _SETTING),
    260: ("OBLIQUE_SURVEY", _CAMERA),
    300: ("MISSION_START", _MARK),
    310: ("ACTUATOR_TEST", _DEVICE),
    311: ("CONFIGURE_ACTUATOR", _DEVICE),
    312: ("ESC_REQUEST_EEPROM", _DEVICE),
    400: ("COMPONENT_ARM_DISARM", "the robot is always armed"),
    401: ("RUN_PREARM_CHECKS", _SETTING),
    405: ("ILLUMINATOR_ON_OFF", _DEVICE),
    406: ("DO_ILLUMINATOR_CONFIGURE", _DEVICE),
    410: ("GET_HOME_POSITION", _SETTING),
    420: ("INJECT_FAILURE", _SETTING),
    500: ("START_RX_PAIR", _DEVICE),
    510: ("GET_MESSAGE_INTERVAL", _SETTING),
    511: ("SET_MESSAGE_INTERVAL", _SETTING),
    512: ("REQUEST_MESSAGE", _SETTING),
    519: ("REQUEST_PROTOCOL_VERSION", _SETTING),
    520: ("REQUEST_AUTOPILOT_CAPABILITIES", _SETTING),
    521: ("REQUEST_CAMERA_INFORMATION", _CAMERA),
    522: ("REQUEST_CAMERA_SETTINGS", _CAMERA),
    525: ("REQUEST_STORAGE_INFORMATION", _CAMERA),
    526: ("STORAGE_FORMAT", _CAMERA),
    527: ("REQUEST_CAMERA_CAPTURE_STATUS", _CAMERA),
    528: ("REQUEST_FLIGHT_INFORMATION", _SETTING),
    529: ("RESET_CAMERA_SETTINGS", _CAMERA),
    530: ("SET_CAMERA_MODE", _CAMERA),
    531: ("SET_CAMERA_ZOOM", _CAMERA),
    532: ("SET_CAMERA_FOCUS", _CAMERA),
    533: ("SET_STORAGE_USAGE", _CAMERA),
    534: ("SET_CAMERA_SOURCE", _CAMERA),
    550: ("SET_AT_S_PARAM", _SETTING),
    610: ("DO_SET_SYS_CMP_ID", _SETTING),
    611: ("DO_SET_GLOBAL_ORIGIN", _SETTING),
    1000: ("DO_GIMBAL_MANAGER_PITCHYAW", _GIMBAL),
    1001: ("DO_GIMBAL_MANAGER_CONFIGURE", _GIMBAL),
    2001: ("IMAGE_STOP_CAPTURE", _CAMERA),
    2002: ("REQUEST_CAMERA_IMAGE_CAPTURE", _CAMERA),
    2003: ("DO_TRIGGER_CONTROL", _CAMERA),
    2004: ("CAMERA_TRACK_POINT", _CAMERA),
    2005: ("CAMERA_TRACK_RECTANGLE", _CAMERA),
    2010: ("CAMERA_STOP_TRACKING", _CAMERA),
    2020: ("CAMERA_START_MTI", _CAMERA),
    2021: ("CAMERA_STOP_MTI", _CAMERA),
    2500: ("VIDEO_START_CAPTURE", _CAMERA),
    2501: ("VIDEO_STOP_CAPTURE", _CAMERA),
    2502: ("VIDEO_START_STREAMING", _CAMERA),
    2503: ("VIDEO_STOP_STREAMING", _CAMERA),
    2504: ("REQUEST_VIDEO_STREAM_INFORMATION", _CAMERA),
    2505: ("REQUEST_VIDEO_STREAM_STATUS", _CAMERA),
    2510: ("LOGGING_START", _SETTING),
    2511: ("LOGGING_STOP", _SETTING),
    2520: ("AIRFRAME_CONFIGURATION", _GROUND),
    2600: ("CONTROL_HIGH_LATENCY", _SETTING),
    2800: ("PANORAMA_CREATE", _CAMERA),
    3000: ("DO_VTOL_TRANSITION", _GROUND),
    3001: ("ARM_AUTHORIZATION_REQUEST", _SETTING),
    4501: ("CONDITION_GATE", _WAIT),
    5200: ("UAVCAN_GET_NODE_INFO", _SETTING),
    5300: ("DO_SET_SAFETY_SWITCH_STATE", _DEVICE),
    10001: ("DO_ADSB_OUT_IDENT", _DEVICE),
    10151: ("LOWEHEISER_SET_STATE", _DEVICE),
    12900: ("ODID_SET_EMERGENCY", _SETTING),
    30002: ("PAYLOAD_CONTROL_DEPLOY", _DEVICE),
    31005: ("SPATIAL_USER_1", _DEVICE),
    31006: ("SPATIAL_USER_2", _DEVICE),
    31007: ("SPATIAL_USER_3", _DEVICE),
    31008: ("SPATIAL_USER_4", _DEVICE),
    31009: ("SPATIAL_USER_5", _DEVICE),
    31010: ("USER_1", _DEVICE),
    31011: ("USER_2", _DEVICE),
    31012: ("USER_3", _DEVICE),
    31013: ("USER_4", _DEVICE),
    31014: ("USER_5", _DEVICE),
    32000: ("CAN_FORWARD", _SETTING),
    40001: ("RESET_MPPT", _DEVICE),
    40002: ("PAYLOAD_CONTROL", _DEVICE),
    42000: ("POWER_OFF_INITIATED", _SETTING),
    42004: ("FIXED_MAG_CAL", _SETTING),
    42005: ("FIXED_MAG_CAL_FIELD", _SETTING),
    42006: ("FIXED_MAG_CAL_YAW", _SETTING),
    42007: ("SET_EKF_SOURCE_SET", _SETTING),
    42424: ("DO_START_MAG_CAL", _SETTING),
    42425: ("DO_ACCEPT_MAG_CAL", _SETTING),
    42426: ("DO_CANCEL_MAG_CAL", _SETTING),
    42427: ("SET_FACTORY_TEST_MODE", _SETTING),
    42428: ("DO_SEND_BANNER", _SETTING),
    42429: ("ACCELCAL_VEHICLE_POS", _SETTING),
    42501: ("GIMBAL_RESET", _GIMBAL),
    42502: ("GIMBAL_AXIS_CALIBRATION_STATUS", _GIMBAL),
    42503: ("GIMBAL_REQUEST_AXIS_CALIBRATION", _GIMBAL),
    42505: ("GIMBAL_FULL_RESET", _GIMBAL),
    42600: ("DO_WINCH", _DEVICE),
    42650: ("FLASH_BOOTLOADER", _SETTING),
    42651: ("BATTERY_RESET", _SETTING),
    42700: ("DEBUG_TRAP", _SETTING),
    42701: ("SCRIPTING", _DEVICE),
    43000: ("GUIDED_CHANGE_SPEED", _SPEED),
    43001: ("GUIDED_CHANGE_ALTITUDE", _GROUND),
    43002: ("GUIDED_CHANGE_HEADING", _FACING),
    43003: ("EXTERNAL_POSITION_ESTIMATE", _SETTING),
    43004: ("EXTERNAL_WIND_ESTIMATE", _SETTING),
    43005: ("SET_HAGL", _SETTING),
    60002: ("STORM32_DO_GIMBAL_MANAGER_CONTROL_PITCHYAW", _GIMBAL),
    60010: ("STORM32_DO_GIMBAL_MANAGER_SETUP", _GIMBAL),
}

_VEHICLE: Final = "it steers the vehicle by itself; give waypoints in its place"
_FENCE: Final = "a fence belongs into geoFence"

# Those that change where or when the vehicle goes, and cannot be followed: MAVLink's name, and what to do instead.
INSTEAD: Final = {
    23: ("NAV_LAND_LOCAL", "its place is not in latitude and longitude; give a waypoint in its place"),
    24: ("NAV_TAKEOFF_LOCAL", "its place is not in latitude and longitude; give a waypoint in its place"),
    25: ("NAV_FOLLOW", _VEHICLE),
    32: ("DO_FOLLOW", _VEHICLE),
    33: ("DO_FOLLOW_REPOSITION", _VEHICLE),
    34: ("DO_ORBIT", _VEHICLE),
    35: ("DO_FIGURE_EIGHT", _VEHICLE),
    36: ("NAV_ARC_WAYPOINT", "its way is an arc; give waypoints along it"),
    81: ("NAV_PATHPLANNING", _VEHICLE),
    92: ("NAV_GUIDED_ENABLE", _VEHICLE),
    176: ("DO_SET_MODE", _VEHICLE),
    179: ("DO_SET_HOME", "the home is where the robot starts, or the mission's onboard.home"),
    185: ("DO_FLIGHTTERMINATION", "it ends the flight; end the plan there"),
    190: ("DO_RALLY_LAND", _VEHICLE),
    191: ("DO_GO_AROUND", _VEHICLE),
    192: ("DO_REPOSITION", _VEHICLE),
    193: ("DO_PAUSE_CONTINUE", "a mission holds by a delay (93), or by 'schedule'"),
    213: ("NAV_SET_YAW_SPEED", _VEHICLE),
    222: ("DO_GUIDED_LIMITS", _VEHICLE),
    224: ("DO_SET_MISSION_CURRENT", "a jump (177) that is done a number of times can be followed"),
    246: ("PREFLIGHT_REBOOT_SHUTDOWN", "it ends the flight; end the plan there"),
    252: ("OVERRIDE_GOTO", _VEHICLE),
    262: ("DO_SET_STANDARD_MODE", _VEHICLE),
    4000: ("SET_GUIDED_SUBMODE_STANDARD", _VEHICLE),
    4001: ("SET_GUIDED_SUBMODE_CIRCLE", _VEHICLE),
    5000: ("NAV_FENCE_RETURN_POINT", _FENCE),
    5001: ("NAV_FENCE_POLYGON_VERTEX_INCLUSION", _FENCE),
    5002: ("NAV_FENCE_POLYGON_VERTEX_EXCLUSION", _FENCE),
    5003: ("NAV_FENCE_CIRCLE_INCLUSION", _FENCE),
    5004: ("NAV_FENCE_CIRCLE_EXCLUSION", _FENCE),
    5005: ("NAV_FENCE_HOME_CIRCLE_INCLUSION", _FENCE),
    5100: ("NAV_RALLY_POINT", "the robot has one home, the mission's onboard.home"),
    30001: ("PAYLOAD_PREPARE_DEPLOY", "it leads to where a payload is dropped; give a waypoint in its place"),
    **{
        31000 + user: (f"WAYPOINT_USER_{user + 1}", "its meaning is not MAVLink's; give a waypoint")
        for user in range(5)
    },
    42702: ("NAV_SCRIPT_TIME", _VEHICLE),
    42703: ("NAV_ATTITUDE_TIME", _VEHICLE),
}
