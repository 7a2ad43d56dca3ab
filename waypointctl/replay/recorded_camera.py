"""The camera of a flight that is flown again: each picture is drawn again where the same renderer is."""

from __future__ import annotations

from waypointctl.flight.camera import FORMAT, FRAME, OnboardCamera
from waypointctl.log.messages import Event, Picture, State
from waypointctl.log.png import SOFTWARE, texts_of
from waypointctl.log.records import shown
from waypointctl.replay.comparator import LogComparator


class RecordedCamera:
    """Takes the pictures that the log has: only of the renderer that drew them the same bytes are expected.

    A picture that another renderer drew is checked by its checksums, and handed on as it is. Where the log has none,
    none is drawn now: nothing could draw when it was flown, or they were taken out. Where something can draw, the log
    is then not what is written here.

    Attributes:
        drawn_again: how many pictures were.
        handed_on: how many were drawn by another renderer.
        missing: how many observations the log has no picture of.
    """

    def __init__(self, camera: OnboardCamera, comparator: LogComparator) -> None:
        """Hold `camera` against `comparator`."""
        self.drawn_again = self.handed_on = self.missing = 0
        self._camera = camera
        self._comparator = comparator

    def __call__(self, event: Event, state: State) -> Picture | None:
        """Return what the log should have as the picture of an observation; None where it has none."""
        logged = self._comparator.upcoming if self._comparator.upcoming_kind is Picture else None
        if not isinstance(logged, Picture):
            self.missing += 1
            return None
        try:
            renderer = texts_of(logged.data).get(SOFTWARE, "")
        except ValueError as error:
            raise self._comparator.diverged("/camera", "data", shown(logged.data), str(error)) from error
        if renderer and renderer == self._camera.renderer:
            self.drawn_again += 1
            return self._camera(event, state)
        self.handed_on += 1
        return Picture(event.time_ns, FRAME, FORMAT, logged.data)

    @property
    def checks(self) -> tuple[str, ...]:
        """What was compared of the pictures, a line each."""
        lines = []
        if self.drawn_again:
            lines.append(f"{_pictures(self.drawn_again)}, drawn again, byte for byte")
        if self.missing and not self._could_be_there:
            lines.append(self._without)
        return tuple(lines)

    @property
    def not_compared(self) -> tuple[str, ...]:
        """What could not be compared of the pictures, a line each."""
        lines = []
        if self.handed_on:
            lines.append(f"{_pictures(self.handed_on)}: {self._why_not}")
        if self.missing and self._could_be_there:
            lines.append(self._without)
        return tuple(lines)

    @property
    def _could_be_there(self) -> bool:
        """Whether a picture that the log does not have would be there if the flight were flown here."""
        return bool(self.drawn_again or self.handed_on or self._camera.renderer)

    @property
    def _without(self) -> str:
        return f"{self.missing} observation{'s' * (self.missing != 1)} without a picture in the log"

    @property
    def _why_not(self) -> str:
        if not self._camera.renderer:
            return f"nothing can draw here: {self._camera.trouble.splitlines()[0]}"
        return f"another renderer drew {'it' if self.handed_on == 1 else 'them'}"


def _pictures(count: int) -> str:
    return "1 picture" if count == 1 else f"{count} pictures"
