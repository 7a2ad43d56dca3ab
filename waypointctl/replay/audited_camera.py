"""The camera of a flight that is flown again: each picture is drawn again where the same would come of it."""

from __future__ import annotations

from waypointctl.log.messages import Event, Picture, State
from waypointctl.log.png import SOFTWARE, texts_of
from waypointctl.ops.camera import FORMAT, FRAME, OnboardCamera
from waypointctl.replay.difference import shown
from waypointctl.replay.witness import Witness


class AuditedCamera:
    """Takes the pictures that the log has: the same bytes are asked of the renderer that drew them alone.

    A picture that another renderer drew is found whole by its checksums, and handed on as it is. Where the log has
    none, nothing could draw when it was flown, and none is drawn now.

    Attributes:
        drawn_again: how many pictures were.
        handed_on: how many were drawn by another renderer.
        missing: how many observations the log has no picture of.
    """

    def __init__(self, camera: OnboardCamera, witness: Witness, *, same_program: bool) -> None:
        """Hold `camera` against `witness`; another program may draw another scene, whatever draws for it."""
        self.drawn_again = self.handed_on = self.missing = 0
        self._camera = camera
        self._witness = witness
        self._same_program = same_program

    def __call__(self, event: Event, state: State) -> Picture | None:
        """Return what the log should have as the picture of an observation; None where it has none."""
        logged = self._witness.upcoming if self._witness.upcoming_kind is Picture else None
        if not isinstance(logged, Picture):
            self.missing += 1
            return None
        try:
            renderer = texts_of(logged.data).get(SOFTWARE, "")
        except ValueError as error:
            raise self._witness.diverged("/camera", "data", shown(logged.data), str(error)) from error
        if self._same_program and renderer and renderer == self._camera.renderer:
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
        if self.handed_on:  # why not is asked of what draws, which a log without pictures never sets up
            lines.append(f"{_pictures(self.handed_on)} not compared: {self._why_not}")
        if self.missing:
            lines.append(f"{self.missing} observation{'s' * (self.missing != 1)} without a picture in the log")
        return tuple(lines)

    @property
    def _why_not(self) -> str:
        them = "it" if self.handed_on == 1 else "them"
        if not self._same_program:
            return f"another program or processor drew {them}"
        if not self._camera.renderer:
            return f"nothing can draw here: {self._camera.trouble.splitlines()[0]}"
        return f"another renderer drew {them}"


def _pictures(count: int) -> str:
    return "1 picture" if count == 1 else f"{count} pictures"
