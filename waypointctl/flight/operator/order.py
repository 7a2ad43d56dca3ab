"""What an operator wants sent, before it has an id and a time."""

from __future__ import annotations

from dataclasses import dataclass

from waypointctl.flight.executive.plan import names
from waypointctl.log.messages import Command, CommandKind, PlannedWaypoint


@dataclass(frozen=True, slots=True)
class Order:
    """A command to be; see `Command` for what the arguments mean."""

    kind: CommandKind
    waypoints: tuple[PlannedWaypoint, ...] = ()
    on_failure: str = "abort"
    released: int = -1
    target_id: int = -1
    value: float = 0.0
    not_before_ns: int = -1
    expires_ns: int = -1
    fleeting: bool = False  # the next one takes its place, so that nobody waits for this one's acknowledgement

    @property
    def words(self) -> str:
        """The order in a few words."""
        parts = [self.kind.value, names(self.waypoints)]
        if self.kind in (CommandKind.SET_TOLERANCE, CommandKind.SET_TIMEOUT):
            parts.append(f"{self.value:g} {'m' if self.kind is CommandKind.SET_TOLERANCE else 's'}")
        if self.kind is CommandKind.CANCEL:
            parts.append(f"command {self.target_id}")
        if self.kind is CommandKind.RELEASE:
            parts.append("all" if self.released < 0 else str(self.released))
        return " ".join(part for part in parts if part)

    def command(self, command_id: int, attempt: int, issued_ns: int, received_ns: int) -> Command:
        """Return the order as it arrives."""
        return Command(
            id=command_id,
            kind=self.kind,
            waypoints=self.waypoints,
            on_failure=self.on_failure,
            issued_ns=issued_ns,
            received_ns=received_ns,
            attempt=attempt,
            released=self.released,
            target_id=self.target_id,
            value=self.value,
            not_before_ns=self.not_before_ns,
            expires_ns=self.expires_ns,
        )
