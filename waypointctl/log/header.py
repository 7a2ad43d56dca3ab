"""What comes before the messages of a log: the mission's setting and the header; and the index of what a log holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl import __version__
from waypointctl.log.messages import FloatArray, PlannedWaypoint
from waypointctl.mission.onboard import Zone
from waypointctl.units import NS_PER_S, seconds

if TYPE_CHECKING:
    from mcap.records import Channel, Schema

    from waypointctl.sim.geometry import Geom

SCHEMA_VERSION: Final = 2  # of topics, schemas and metadata; a log of another one is refused
METADATA_NAME: Final = "waypointctl"  # of the MCAP metadata record; a log without it is not ours
LIBRARY: Final = f"waypointctl {__version__}"  # of the MCAP header
LAYOUT_NAME: Final = "foxglove-layout.json"
IntArray: TypeAlias = NDArray[np.int64]
Span: TypeAlias = tuple[int, int]  # from when to when [ns]


@dataclass(frozen=True, slots=True, eq=False)
class ContactWindows:
    """When something can be sent one way of the link."""

    begin_ns: IntArray  # of each window, (n,), in order
    end_ns: IntArray  # of each window, (n,)
    period_ns: int = 0  # after this all of them come again; 0 for never

    def is_open(self, time_ns: IntArray) -> NDArray[np.bool_]:
        """Tell for each of some times (m,) [ns] whether there is contact."""
        within = time_ns % self.period_ns if self.period_ns else time_ns
        window = np.searchsorted(self.begin_ns, within, "right") - 1
        return (window >= 0) & (within < self.end_ns[np.maximum(window, 0)])

    def change_ns(self, now_ns: int) -> int | None:
        """Return when contact begins or ends next after `now_ns`; None for never again."""
        round_ns = now_ns - now_ns % self.period_ns if self.period_ns else 0
        edges = round_ns + np.sort(np.concatenate([self.begin_ns, self.end_ns]))
        edges = np.concatenate([edges, edges + self.period_ns])
        later = edges[edges > now_ns]
        changes = later[self.is_open(later) != self.is_open(np.array([now_ns]))]  # a window may begin as one ends
        return int(changes[0]) if len(changes) else None

    def state_text(self, now_ns: int) -> str:
        """Return whether there is contact, and until when: "open until 12.50 s"."""
        is_open, change_ns = bool(self.is_open(np.array([now_ns]))[0]), self.change_ns(now_ns)
        until = "from now on" if change_ns is None else f"until {seconds(change_ns):.2f} s"
        return f"{'open' if is_open else 'closed'} {until}"

    def closed(self, until_ns: int, most: int) -> tuple[Span, ...] | None:
        """Return the spans without contact from 0 to `until_ns`; None where there are more than `most` windows."""
        rounds = until_ns // self.period_ns + 1 if self.period_ns else 1
        if rounds * len(self.begin_ns) > most:
            return None
        shifts = range(0, rounds * self.period_ns, self.period_ns) if self.period_ns else (0,)
        edges = [0]
        for shift in shifts:
            for begin_ns, end_ns in zip(self.begin_ns.tolist(), self.end_ns.tolist(), strict=True):
                edges += [begin_ns + shift, end_ns + shift]
        edges.append(max(until_ns, edges[-1]))
        spans = zip(edges[::2], edges[1::2], strict=True)
        return tuple((begin, min(end, until_ns)) for begin, end in spans if begin < min(end, until_ns))


@dataclass(frozen=True, slots=True, eq=False)
class MissionSetting:
    """What a mission fixes before its flight."""

    home: PlannedWaypoint | None = None  # where the robot returns to; None where no mission is known
    may_return: bool = False  # whether the mission names a home, or a rule or a command that sends the robot there
    zones: tuple[Zone, ...] = ()  # of its geofence
    up: ContactWindows | None = None  # contact from the operator to the robot; None where there is always contact
    down: ContactWindows | None = None  # contact from the robot to the operator; likewise

    def home_to_show(self, *, has_returned: bool) -> PlannedWaypoint | None:
        """Return home where it matters: the robot has set out for it, or may do so by the mission's rules."""
        return self.home if has_returned or self.may_return else None

    @property
    def ways(self) -> Mapping[str, ContactWindows | None]:
        """Contact each way, by its name."""
        return {"up": self.up, "down": self.down}


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


class Kinematics(Protocol):
    """Where a robot's bodies are. Its root is a free joint: qpos and qvel begin with its 7 and 6 numbers."""

    @property
    def body_names(self) -> tuple[str, ...]:
        """The robot's bodies, the root first, without the world."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The hinge and slide joints, in the order of qpos[7:] and qvel[6:]."""

    @property
    def geoms(self) -> tuple[Geom, ...]:
        """What is to be drawn."""

    def poses(self, qpos: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the bodies' positions (nbody, 3) [m] and quaternions (nbody, 4) w x y z in the world at qpos (nq,)."""


@dataclass(frozen=True, slots=True)
class TopicSummary:
    """What stands on one topic; times are log times in [ns], None where there is no message."""

    name: str
    schema: str
    count: int
    first_ns: int | None
    last_ns: int | None

    @property
    def rate_hz(self) -> float | None:
        """Messages a second between the first and the last, None for fewer than two moments."""
        if self.first_ns is None or self.last_ns is None or self.first_ns == self.last_ns:
            return None
        return (self.count - 1) * NS_PER_S / (self.last_ns - self.first_ns)


@dataclass(frozen=True, slots=True)
class ChunkPlace:
    """Where a chunk is, and the log times in it."""

    offset: int
    first_ns: int
    last_ns: int


@dataclass(frozen=True, slots=True)
class LogIndex:
    """What a log holds."""

    library: str  # that wrote it
    metadata: Mapping[str, str]
    attachments: Mapping[str, bytes]
    media_types: Mapping[str, str]  # of the attachments
    schemas: Mapping[int, Schema]
    channels: Mapping[int, Channel]
    topics: Mapping[int, TopicSummary]  # by channel
    chunks: tuple[ChunkPlace, ...]
    size_bytes: int
    is_complete: bool
