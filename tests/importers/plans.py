"""Sixty and more plans of the shapes that are found in public repositories, each with what it means, by hand.

Every plan is built from MAVLink's and QGroundControl's documents. Places are counted in steps of 0.0001 degrees north
and east of the home at 60 N 25 E: a step is 11.141 m north and 5.580 m east there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, TypeAlias

Steps: TypeAlias = tuple[float, float]  # north and east of the home

HOME: Final = (60.0, 25.0)
NORTH_M: Final = 11.141
EAST_M: Final = 5.580
_NAN: Final = float("nan")


@dataclass(frozen=True)
class At:
    """A waypoint that is expected."""

    north: float
    east: float
    hold_s: float = 0.0
    radius_m: float | None = None
    observe: bool = False
    name: str | None = None


@dataclass(frozen=True)
class Shape:
    """A plan, and what it means.

    Attributes:
        title: what is special about it.
        plan: the file.
        stops: waypoints, in order.
        left_out: how each line begins of what is left out.
        allowed: places that the fence allows.
        forbidden: places that it does not.
        home: where a robot goes that breaks the fence.
        refused: what the refusal says; the plan is imported where it is empty.
    """

    title: str
    plan: dict[str, Any]
    stops: tuple[At | Steps, ...] = ()
    left_out: tuple[str, ...] = ()
    allowed: tuple[Steps, ...] = ()
    forbidden: tuple[Steps, ...] = ()
    home: Steps | None = None
    refused: str = ""


def degrees(north: float, east: float) -> list[float]:
    """Return latitude and longitude."""
    return [HOME[0] + north * 1e-4, HOME[1] + east * 1e-4]


def item(command: int, *params: float | None, frame: int = 2, **more: object) -> dict[str, Any]:
    """Return an item without a place: what is not given of its seven parameters is 0."""
    values = [*params, *[0] * 7][:7]
    return {
        "type": "SimpleItem", "command": command, "frame": frame, "params": values, "autoContinue": True, **more,
    }  # fmt: skip


def there(
    command: int, north: float, east: float, *params: float | None, frame: int = 3, **more: object
) -> dict[str, Any]:
    """Return an item at a place, 10 m high, with its first four parameters."""
    first = [*params, *[0, 0, 0, None][len(params) :]]
    return item(command, *first, *degrees(north, east), 10, frame=frame, **more)


def wp(north: float, east: float, *params: float | None, **more: Any) -> dict[str, Any]:
    """Return a waypoint."""
    return there(16, north, east, *params, **more)


def plan(*items: dict[str, Any], fence: object = None, home: object = None, **more: object) -> dict[str, Any]:
    """Return a plan as QGroundControl writes it, its items with the numbers that jumps name them by."""
    numbered = [
        {"doJumpId": number, "AMSLAltAboveTerrain": None, "Altitude": 10, "AltitudeMode": 1} | each
        for number, each in enumerate(items, 1)
    ]
    mission = {
        "version": 2, "firmwareType": 12, "vehicleType": 2, "cruiseSpeed": 15, "hoverSpeed": 5,
        "globalPlanAltitudeMode": 1, "plannedHomePosition": [*HOME, 10] if home is None else home, "items": numbered,
    }  # fmt: skip
    return {
        "fileType": "Plan", "version": 1, "groundStation": "QGroundControl", "mission": mission,
        "geoFence": {"circles": [], "polygons": [], "version": 2} if fence is None else fence,
        "rallyPoints": {"points": [], "version": 2},
    } | more  # fmt: skip


def circle(north: float, east: float, radius_m: float, *, inclusion: bool) -> dict[str, Any]:
    """Return a circle of a fence."""
    return {"circle": {"center": degrees(north, east), "radius": radius_m}, "inclusion": inclusion, "version": 1}


def box(south: float, west: float, north: float, east: float, *, inclusion: bool) -> dict[str, Any]:
    """Return a rectangle of a fence."""
    corners = [degrees(*corner) for corner in ((south, west), (north, west), (north, east), (south, east))]
    return {"polygon": corners, "inclusion": inclusion, "version": 1}


def fence(*areas: dict[str, Any], **more: object) -> dict[str, Any]:
    """Return a fence."""
    return {
        "version": 2,
        "circles": [area for area in areas if "circle" in area],
        "polygons": [area for area in areas if "polygon" in area],
        **more,
    }


def laid_out(kind: str, *items: dict[str, Any]) -> dict[str, Any]:
    """Return a survey or the like, with the simple items that QGroundControl laid it out as."""
    numbered = [{"doJumpId": number} | each for number, each in enumerate(items, 2)]
    inner = {"version": 2, "CameraShots": 9, "Items": numbered, "TurnAroundDistance": 5, "VisualTransectPoints": []}
    return {"type": "ComplexItem", "complexItemType": kind, "version": 5, "TransectStyleComplexItem": inner}


def landing(kind: str, **places: list[float]) -> dict[str, Any]:
    """Return a landing pattern."""
    return {"type": "ComplexItem", "complexItemType": kind, "version": 2, "loiterRadius": 75, **places}


A, B = wp(2, 0), wp(2, 4)
AB: Final = ((2.0, 0.0), (2.0, 4.0))
YARD: Final = box(-5, -10, 5, 10, inclusion=True)
CHANGES_SPEED: Final = "x DO_CHANGE_SPEED (command 178)"

SHAPES: Final = (
    # The way.
    Shape("waypoints alone", plan(A, B), AB),
    Shape("nothing but the mission", {"fileType": "Plan", "version": 1, "mission": plan(A, B)["mission"]}, AB),
    Shape("items after a return, which no jump leads to", plan(A, B, item(20), item(189), there(21, 9, 9)),
          (*AB, At(0, 0, name="home")), ("1 x DO_LAND_START", "1 x item after the return (command 20)")),
    Shape("items after a return, which a jump leads to",
          plan(A, item(177, 4, 1), item(20), B, item(177, 3, 1), there(21, 9, 9)),
          (*AB, At(0, 0, name="home")), ("1 x item after the return (command 20)",)),
    Shape("a take-off without a place, and a return", plan(item(22, frame=3), A, B, item(20)),
          (*AB, At(0, 0, name="home")), ("1 x takeoff",)),
    Shape("a take-off with a place of nulls", plan(item(22, 15, 0, 0, None, None, None, 50, frame=3), A, B),
          AB, ("1 x takeoff",)),
    Shape("a take-off where the home is, and a landing there", plan(there(22, 0, 0), A, B, there(21, 0, 0)),
          (*AB, At(0, 0, name="land")), ("1 x takeoff", "1 x landing")),
    Shape("a take-off elsewhere", plan(there(22, 5, 0, 15), wp(2, 4)),
          (At(5, 0, name="takeoff"), (2, 4)), ("1 x takeoff",)),
    Shape("holds and acceptance radii", plan(wp(2, 0, 4, 1.5), wp(2, 4, 0, 3)),
          (At(2, 0, 4, 1.5), At(2, 4, 0, 3))),
    Shape("headings", plan(wp(2, 0, 0, 0, 0, 90), wp(2, 4, 0, 0, 0, 0)), AB, ("1 x heading at a waypoint",)),
    Shape("a passing radius", plan(wp(2, 0, 0, 0, 5), B), AB, ("1 x passing radius of a waypoint",)),
    Shape("splines", plan(A, there(82, 2, 4, 3)), ((2, 0), At(2, 4, 3)), ("1 x spline waypoint",)),
    Shape("heights above the sea", plan(wp(2, 0, frame=0), wp(2, 4, frame=0)), AB),
    Shape("heights above the ground", plan(wp(2, 0, frame=10), wp(2, 4, frame=11)), AB),
    Shape("frames of integers", plan(wp(2, 0, frame=5), wp(2, 4, frame=6)), AB),
    Shape("a local frame", plan(item(16, 0, 0, 0, 0, 20, 5, -3, frame=1)), refused=r"items\[0\]\.frame: 1 is not one"),
    Shape("the first plans: four parameters and a coordinate",
          plan({"type": "SimpleItem", "command": 16, "frame": 3, "autoContinue": True, "params": [3, 0, 0, 0],
                "coordinate": [*degrees(2, 0), 10]}, B), (At(2, 0, 3), (2, 4))),
    Shape("NaN as Python writes it", plan(item(22, 0, 0, 0, _NAN, _NAN, _NAN, 10, frame=3), wp(2, 0, 0, 0, 0, _NAN), B),
          AB, ("1 x takeoff",)),
    Shape("waits for a person", plan(A | {"autoContinue": False}, B), AB, ("1 x wait for a person",)),
    Shape("mission without a version", (lambda made: made | {"mission": {
        key: value for key, value in made["mission"].items() if key != "version"}})(plan(A, B)), AB),
    Shape("an unset home", plan(A, B, home=[0, 0, 0]), refused=r"mission\.plannedHomePosition \(0, 0\): some 7,000 km"),
    # Standing still.
    Shape("a loiter for a time", plan(A, there(19, 2, 4, 30, 0, 50)), ((2, 0), At(2, 4, 30)),
          ("1 x loiter radius",)),
    Shape("a loiter where the vehicle is", plan(A, item(19, 10, frame=3), B), (At(2, 0, 10), (2, 4))),
    Shape("a loiter at nulls", plan(A, item(19, 10, 0, 0, None, None, None, 10, frame=3), B), (At(2, 0, 10), (2, 4))),
    Shape("a loiter before the first waypoint", plan(item(19, 10, frame=3), A),
          (At(0, 0, 10, name="start"), (2, 0))),
    Shape("loiter turns", plan(A, there(18, 2, 4, 3, 0, 20)), AB, ("1 x loiter turns",)),
    Shape("loiter turns where the vehicle is", plan(A, item(18, 3, frame=3), B), AB, ("1 x loiter turns",)),
    Shape("a loiter without end", plan(A, there(17, 2, 4)), AB, ("1 x loiter without end",)),
    Shape("a loiter to a height", plan(A, there(31, 2, 4)), AB, ("1 x loiter to altitude",)),
    Shape("a delay", plan(A, item(93, 12.5, -1, -1, -1), B), (At(2, 0, 12.5), (2, 4))),
    Shape("a delay first", plan(item(93, 5, -1, -1, -1), A), (At(0, 0, 5, name="start"), (2, 0))),
    Shape("a landing midway", plan(A, there(21, 2, 4), item(93, 30), there(22, 2, 4), wp(0, 4)),
          ((2, 0), At(2, 4, 30, name="land"), (0, 4)), ("1 x landing", "1 x takeoff")),
    Shape("a landing midway where the vehicle is", plan(A, item(21, frame=3), item(93, 30), item(22, frame=3), B),
          (At(2, 0, 30), (2, 4)), ("1 x landing", "1 x takeoff")),
    Shape("two landings", plan(there(21, 2, 0), there(22, 2, 0), there(21, 2, 4)),
          (At(2, 0, name="land"), At(2, 4, name="land 2")), ("2 x landing", "1 x takeoff")),
    # What a robot on foot does not do.
    Shape("speeds", plan(item(178, 1, 5), A, item(178, 1, 3), B), AB, (f"2 {CHANGES_SPEED}",)),
    Shape("regions of interest", plan(there(195, 9, 9), A, B, item(197)), AB,
          ("1 x DO_SET_ROI_LOCATION (command 195)", "1 x DO_SET_ROI_NONE (command 197)")),
    Shape("a gimbal", plan(item(205, -90), A, item(1000, -45), B), AB,
          ("1 x DO_MOUNT_CONTROL (command 205)", "1 x DO_GIMBAL_MANAGER_PITCHYAW (command 1000)")),
    Shape("a camera by distance", plan(A, item(206, 25, 0, 1), B, item(206)), AB,
          ("2 x DO_SET_CAM_TRIGG_DIST (command 206)",)),
    Shape("single pictures", plan(A, item(2000, 0, 0, 1), B, item(203, 0, 0, 0, 0, 1)),
          (At(2, 0, observe=True), At(2, 4, observe=True))),
    Shape("pictures at intervals", plan(A, item(2000, 0, 2, 0), B, item(2001)), AB,
          ("1 x IMAGE_STOP_CAPTURE (command 2001)", "1 x picture (command 2000)")),
    Shape("a video", plan(item(530, 0, 1), A, item(2500), B, item(2501)), AB,
          ("1 x SET_CAMERA_MODE", "1 x VIDEO_START_CAPTURE", "1 x VIDEO_STOP_CAPTURE")),
    Shape("conditions", plan(A, item(115, 90), item(112, 3), B), AB, ("1 x CONDITION_YAW", "1 x CONDITION_DELAY")),
    Shape("servos, relays, a gripper, a winch",
          plan(A, item(183, 8, 1500), item(181, 0, 1), item(211, 1), item(42600, 1), B), AB,
          ("1 x DO_SET_SERVO", "1 x DO_SET_RELAY", "1 x DO_GRIPPER", "1 x DO_WINCH")),
    Shape("arming, a sprayer, a switch", plan(item(400, 1), A, item(216, 1), item(218, 9, 2), B), AB,
          ("1 x COMPONENT_ARM_DISARM", "1 x DO_SPRAYER", "1 x DO_AUX_FUNCTION")),
    Shape("a panorama and a tracked point", plan(A, item(2800, 90), item(2004, 0.5, 0.5), B), AB,
          ("1 x PANORAMA_CREATE", "1 x CAMERA_TRACK_POINT")),
    Shape("a payload that is put down", plan(A, there(94, 2, 4)), AB, ("1 x payload placement",)),
    Shape("an aeroplane's landing", plan(A, item(189), wp(2, 4), there(21, 0, 4)),
          (*AB, At(0, 4, name="land")), ("1 x DO_LAND_START", "1 x landing")),
    Shape("a VTOL", plan(there(84, 2, 0), item(3000, 4), B, there(85, 0, 4)),
          (At(2, 0, name="takeoff"), (2, 4), At(0, 4, name="land")),
          ("1 x DO_VTOL_TRANSITION", "1 x VTOL takeoff", "1 x VTOL landing")),
    Shape("jumps back", plan(A, B, item(177, 1, 2)), (*AB, *AB, *AB)),
    Shape("a jump over an item, and to a tag",
          plan(A, item(177, 4, 1), wp(9, 9), item(600, 7), B, item(601, 7, 1)), (*AB, (2, 4))),
    Shape("a jump without end", plan(A, B, item(177, 1, -1)),
          refused=r"items\[2\]: is a jump \(command 177\) without end"),
    # Patterns.
    Shape("a survey", plan(item(22, frame=3), laid_out("survey", A, item(206, 25, 0, 1), B, item(206)), item(20)),
          (*AB, At(0, 0, name="home")), ("2 x DO_SET_CAM_TRIGG_DIST", "1 x takeoff")),
    Shape("a corridor scan", plan(laid_out("CorridorScan", A, B, wp(0, 4))), (*AB, (0, 4))),
    Shape("a structure scan", plan(A, {"type": "ComplexItem", "complexItemType": "StructureScan", "polygon": []}),
          refused=r"items\[1\]: is a ComplexItem \('StructureScan'\)"),
    Shape("an aeroplane's landing pattern",
          plan(A, landing("fwLandingPattern", landingApproachCoordinate=degrees(2, 4), landCoordinate=degrees(0, 4))),
          (*AB, At(0, 4, name="land")), ("1 x loiter to altitude", "1 x landing")),
    Shape("a VTOL's landing pattern, first version",
          plan(A, landing("vtolLandingPattern", loiterCoordinate=degrees(2, 4), landCoordinate=degrees(0, 4))),
          (*AB, At(0, 4, name="land")), ("1 x loiter to altitude", "1 x VTOL landing")),
    # Fences and rally points.
    Shape("an empty fence of version 1", plan(A, B, fence={"polygon": [], "version": 1}), AB),
    Shape("an empty fence without a version", plan(A, B, fence={}), AB),
    Shape("a fence of version 1", plan(A, B, fence={"polygon": YARD["polygon"], "version": 1}),
          refused=r"geoFence\.version: 1 is not 2"),
    Shape("an inclusion and exclusions",
          plan(A, B, fence=fence(YARD, circle(4, 8, 5, inclusion=False), box(-4, -9, -3, -8, inclusion=False))), AB,
          allowed=((0, 0), (4, 9.1), (-2.9, -8)), forbidden=((4, 8), (-3.5, -8.5), (6, 0))),
    Shape("two inclusions: inside all of them", plan(A, B, fence=fence(YARD, circle(1, 0, 30, inclusion=True))), AB,
          allowed=((2, 0), (1, 5)), forbidden=((1, 8), (5.5, 0), (-3, 0))),
    Shape("a return point that is not set", plan(A, B, fence=fence(YARD, breachReturn=[None, None, None])), AB,
          allowed=((0, 0),), forbidden=((6, 0),)),
    Shape("a return point, and rally points",
          plan(A, B, fence=fence(YARD, breachReturn=[*degrees(3, 1), 50]),
               rallyPoints={"version": 2, "points": [[*HOME, 5], [*HOME, 5]]}), AB,
          ("2 x rally points",), allowed=((0, 0),), forbidden=((6, 0),), home=(3, 1)),
)  # fmt: skip
