"""What a flight's messages have said so far of a command and of a waypoint."""

from __future__ import annotations

from dataclasses import dataclass, field

from waypointctl.log.messages import Ack, CommandKind, PlannedWaypoint, Stage
from waypointctl.replay.story import CommandStory, Fate, WaypointStory


@dataclass(slots=True)
class GrowingCommand:
    """A command; what the attributes mean is CommandStory's to say, but for its kind, known from its arrival on."""

    what: str = ""
    kind: CommandKind | None = None
    issued_ns: int = 0
    received_ns: int | None = None
    carried_ns: int | None = None
    onboard: Stage | None = None
    ended_ns: int | None = None
    attempts: int = 0
    losses: int = 0
    acks: list[Ack] = field(default_factory=list)
    told: tuple[Stage, int] | None = None
    arrivals: list[tuple[int, int]] = field(default_factory=list)

    def story(self, command_id: int) -> CommandStory:
        """Return what is known of it."""
        return CommandStory(
            id=command_id,
            what=self.what,
            issued_ns=self.issued_ns,
            received_ns=self.received_ns,
            uplink_ns=self.carried_ns,
            onboard=self.onboard,
            ended_ns=self.ended_ns,
            attempts=self.attempts,
            losses=self.losses,
            acks=tuple(self.acks),
            told=self.told,
            arrivals=tuple(self.arrivals),
        )


@dataclass(slots=True)
class GrowingWaypoint:
    """A waypoint; what the attributes mean is WaypointStory's to say."""

    planned: PlannedWaypoint
    fate: Fate = Fate.OPEN
    started_ns: int | None = None
    ended_ns: int | None = None
    reached_ns: int | None = None
    learned_ns: int | None = None

    def story(self) -> WaypointStory:
        """Return what is known of it."""
        return WaypointStory(self.planned, self.fate, self.started_ns, self.ended_ns, self.reached_ns, self.learned_ns)
