"""Where the messages of a flight go, and its camera: pictures as messages, or why there are none."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self, TypeAlias

from waypointctl.log.messages import Event, EventKind, Message, Picture, PlannedWaypoint, State

if TYPE_CHECKING:
    from waypointctl.robots.robot import Robot
    from waypointctl.sim.camera import MountedCamera

FRAME: Final = "camera"
FORMAT: Final = "png"

Sink: TypeAlias = Callable[[Message], None]
Camera: TypeAlias = Callable[[Event, State], Picture | None]


def tee(*sinks: Sink) -> Sink:
    """Return a sink that hands each message to all of `sinks`, in order."""
    if len(sinks) == 1:
        return sinks[0]

    def hand_on(message: Message) -> None:
        for sink in sinks:
            sink(message)

    return hand_on


def with_pictures(sink: Sink, camera: Camera) -> Sink:
    """Return a sink that hands each message on, and after the state of an observation the picture of it.

    A robot that rests shows its next state only when it wakes: it has not moved meanwhile.

    Args:
        sink: takes the messages and the pictures.
        camera: makes the picture of an observation at a state; None where it cannot.
    """
    observations: list[Event] = []

    def take(message: Message) -> None:
        sink(message)
        if isinstance(message, Event) and message.kind is EventKind.OBSERVATION_TAKEN:
            observations.append(message)
        elif observations and isinstance(message, State):
            for event in observations:
                picture = camera(event, message)
                if picture is not None:
                    sink(picture)
            observations.clear()

    return take


class OnboardCamera:
    """A robot's camera, set up at the first picture. Use it in `with`.

    Attributes:
        taken: how many pictures it has taken.
        trouble: why it takes no pictures, and how to fix that; empty where it can, or no picture was requested.
    """

    def __init__(self, robot: Robot, waypoints: Iterable[PlannedWaypoint]) -> None:
        """Make the camera of a robot that sees markers at the waypoints."""
        self.taken = 0
        self.trouble = ""
        self._robot = robot
        self._waypoints = {waypoint.index: waypoint for waypoint in waypoints}

    def __call__(self, event: Event, state: State) -> Picture | None:
        """Return the picture of an observation, at the state in which it was taken; None where nothing can draw."""
        if self._mounted is None:
            return None
        from waypointctl.log.png import to_png

        self.taken += 1
        waypoint = self._waypoints.get(event.waypoint)
        title = waypoint.name if waypoint is not None else f"waypoint {event.waypoint + 1}"
        data = to_png(self._mounted.take(state.qpos), title, self.renderer)
        return Picture(event.time_ns, FRAME, FORMAT, data)

    @cached_property
    def renderer(self) -> str:
        """What draws and packs the pictures, where the bytes are the same; empty where nothing can draw."""
        from waypointctl.log.png import packer

        return "" if self._mounted is None else f"{self._mounted.renderer}, {packer()}"

    def __enter__(self) -> Self:
        """Return the camera."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Give back what it draws with."""
        mounted = self.__dict__.get("_mounted")  # asking for it would set it up
        if mounted is not None:
            mounted.close()

    @cached_property
    def _mounted(self) -> MountedCamera | None:
        from waypointctl.sim.camera import Marker, MountedCamera
        from waypointctl.sim.offscreen import NoRendering

        # In a mission with rounds a place comes again: it bears the name that it had first.
        markers = {(it.x_m, it.y_m): Marker(it.name, it.x_m, it.y_m) for it in reversed(self._waypoints.values())}
        try:
            return MountedCamera(self._robot, markers.values())
        except NoRendering as error:
            self.trouble = str(error)
            return None
