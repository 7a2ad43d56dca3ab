"""Lines and points of a map as a mission: the one line is the path, or the points are, in their order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

from waypointctl.display_text import counted, shown
from waypointctl.importers.importer import MOST_POSITIONS, MOST_STOPS, ImportedMission, Report, Stop
from waypointctl.importers.local_frame import Place


@dataclass(frozen=True, slots=True)
class Spot:
    """A place [deg] with its name, which may be empty, and its position in the file."""

    place: Place
    name: str
    at: str


@dataclass(frozen=True, slots=True)
class Line:
    """A line through places."""

    kind: str  # what the format calls it
    name: str  # may be empty
    at: str  # position in the file
    spots: tuple[Spot, ...] = ()  # the places


@dataclass(slots=True)
class Shapes:
    """What a map holds."""

    report: Report  # of the file
    line_word: str  # what the format calls a line
    point_word: str  # and a point
    order: str = ""  # how the format writes a place, where it is easily written the other way round
    body: str = "earth"  # that the places are on, where the file names it
    lines: list[Line] = field(default_factory=list)  # its lines
    points: list[Spot] = field(default_factory=list)  # its single points, in order
    others: Counter[str] = field(default_factory=Counter)  # what it holds beside, by its format's name, and how often

    def add_line(self, line: Line, count: int, things: str, spots: Callable[[], Iterable[Spot]]) -> None:
        """Take a line; of those after the first only their number and names matter, and their places are not read.

        Args:
            line: without its places.
            count: of its places.
            things: what the format calls them, in the plural.
            spots: reads them.
        """
        if not count:
            self.report.left_out[f"{line.kind} without {things}"] += 1
        elif count > MOST_POSITIONS:
            problem = f"has {count:,} {things}; at most {MOST_POSITIONS:,} are read: cut it into several"
            self.report.add_problem(line.at, problem)
        else:
            self.lines.append(line if self.lines else replace(line, spots=tuple(spots())))

    def imported(self, name: str = "") -> ImportedMission:
        """Return the mission, by its line's name if it has one: the robot goes from the first place to the others.

        Raises:
            MissionError: there is not one line, and no points instead; or something else was found wrong.
        """
        self.report.refuse()
        spots = self._path()
        self.report.refuse()
        left_out = [f"{count} {what}{'s' if count > 1 else ''}" for what, count in self.others.items()]
        if self.lines and self.points:
            left_out.insert(0, counted(len(self.points), f"{self.point_word}s"))
        own = self.lines[0].name if self.lines else ""
        return ImportedMission(
            spots[0].place if spots else None,
            tuple(Stop(spot.place, spot.name, spot.at) for spot in spots[1:]),
            name=own or name,
            start_at=spots[0].at if spots else "",
            left_out=tuple(left_out),
            order=self.order,
            body=self.body,
            is_line=bool(self.lines),
        )

    def _path(self) -> Sequence[Spot]:
        if len(self.lines) == 1:
            return self.lines[0].spots
        if self.lines:
            named = ", ".join(shown(line.name) if line.name else line.at for line in self.lines[:5])
            more = f" and {len(self.lines) - 5:,} more" if len(self.lines) > 5 else ""
            problem = f"has {len(self.lines):,} lines ({named}{more}); a mission is one {self.line_word}: keep one"
            self.report.add_problem("", problem)
        elif len(self.points) < 2:
            found = [counted(len(self.points), f"{self.point_word}s")] if self.points else []
            found += [counted(count, f"{what}s") for what, count in self.others.items()]
            beside = f" and {', '.join(found)}" if found else ""
            problem = (
                f"has no {self.line_word}{beside}; a mission is one {self.line_word}, or 2 {self.point_word}s and more"
            )
            self.report.add_problem("", problem)
        elif len(self.points) > MOST_STOPS + 1:
            limit = f"at most {MOST_STOPS + 1:,} are allowed, the start and {MOST_STOPS:,} waypoints"
            self.report.add_problem("", f"has {len(self.points):,} {self.point_word}s; {limit}: cut it into several")
        return self.points


def note_gaps(report: Report, parts: Iterable[Sequence[object]]) -> None:
    """Count the gaps between the parts of a recorded track."""
    gaps = sum(map(bool, parts)) - 1
    if gaps > 0:
        report.left_out["gap between segments of a track: the robot goes straight across"] += gaps
