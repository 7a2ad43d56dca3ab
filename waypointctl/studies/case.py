"""The flights of a delay study, and the mission that each of them is."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Final, Literal

from waypointctl.errors import InputError, MissionError
from waypointctl.flight.link.build import contacts_of
from waypointctl.mission.fields import DAY_S
from waypointctl.mission.files import MissionFile, load_mission, parse_mission
from waypointctl.mission.link import DelayAt, Link, LinkDirection
from waypointctl.mission.mission import Mission
from waypointctl.units import seconds

BUILT_IN: Final = ("two-point", "ten-point", "short")
_WAYS: Final = ("up", "down")


def load_route(name_or_file: str) -> MissionFile:
    """Return a route that comes with waypointctl, or the mission in a YAML file.

    Raises:
        MissionError: there is no such route or file, or what is in the file is not a mission.
    """
    if name_or_file in BUILT_IN:
        name = f"{name_or_file}.yaml"
        source = files("waypointctl.studies").joinpath("routes", name).read_bytes()
        return MissionFile(parse_mission(source, name), source, Path(name))
    try:
        return load_mission(Path(name_or_file))
    except MissionError as error:
        if Path(name_or_file).suffix:
            raise
        hint = f"give a mission file, or a route that comes with waypointctl: {', '.join(BUILT_IN)}"
        raise MissionError(error.problem, where=error.where, hint=hint, details=error.details) from error


def load_routes(names_or_files: Sequence[str]) -> dict[str, MissionFile]:
    """Return routes by their missions' names.

    Raises:
        MissionError: as for `load_route`.
        InputError: two have one name.
    """
    routes = [load_route(given) for given in names_or_files]
    counts = Counter(route.mission.name for route in routes)
    if twice := [name for name, count in counts.items() if count > 1]:
        raise InputError(
            f"--route: {twice[0]!r} is the name of more than one mission", hint="Give each mission its own name."
        )
    return {route.mission.name: route for route in routes}


def with_round_trip(link: Link, rtt_s: float) -> Link:
    """Return a link whose delays add up to a round trip [s], and that is as `link` is otherwise."""
    up_s = rtt_s * _share_up(link)
    ways = {"up": _delayed(link.up, up_s), "down": _delayed(link.down, rtt_s - up_s)}
    return link.model_copy(update={"preset": None} | ways)  # the preset's values are in the directions


def least_round_trip_s(link: Link) -> float:
    """Return the shortest round trip that a link can have [s]: uniform jitter is not larger than the delay."""
    share = _share_up(link)
    shares = {"up": share, "down": 1 - share}
    return max(_uniform_jitter_s(getattr(link, name)) / shares[name] for name in _WAYS if shares[name])


def refuse_what_is_not_kept(routes: Mapping[str, MissionFile], rtts_s: Sequence[float] = ()) -> None:
    """Refuse missions of which a study would have to drop something, and round trips that a link cannot have.

    Raises:
        InputError: it names the mission's file, everything that would be dropped, and what to do.
    """
    for file in routes.values():
        if dropped := [*_not_kept(file.mission)]:
            raise InputError(
                f"a delay study cannot keep {'; '.join(dropped)}",
                where=str(file.path),
                hint="Leave that out of a copy of the mission, and study the copy.",
            )
        least_s = least_round_trip_s(file.mission.link)
        if rtts_s and min(rtts_s) < least_s:
            raise InputError(
                f"--rtt: {min(rtts_s):g} s is less than {least_s:g} s, the least at which the link's jitter is within "
                "its delay",
                where=str(file.path),
                hint="Give longer round trips, or leave link.jitter out of a copy of the mission.",
            )


def _not_kept(mission: Mission) -> Iterator[str]:
    for name in _WAYS:
        if getattr(mission.link, name).delay_table is not None:
            yield f"link.{name}.delay_table, a delay that changes with time"
    if mission.schedule:
        yield "schedule, whose commands have fixed times and are meant for one autonomy"


def _share_up(link: Link) -> float:
    both_s = link.up.delay_s + link.down.delay_s
    return link.up.delay_s / both_s if both_s else 0.5


def _uniform_jitter_s(way: LinkDirection) -> float:
    return way.jitter_s if way.jitter_distribution == "uniform" else 0.0


def _delayed(way: LinkDirection, delay_s: float) -> LinkDirection:
    delay_s = max(delay_s, _uniform_jitter_s(way))  # equal but for rounding, where the round trip is the least
    if way.contact_plan is None:
        return way.model_copy(update={"delay_s": delay_s})
    # With a contact plan a delay of 0 means the plan's; a table of one row takes the place of the plan's ranges.
    return way.model_copy(update={"delay_s": 0.0, "delay_table": (DelayAt(at_s=0.0, delay_s=delay_s),)})


# The finer sweep in which `joint` is followed to where it fails [s].
FINE_RTTS_S: Final = tuple(step * 20 / 1000 for step in range(14))

_MOST_SENDS: Final = 10  # of a command over a link that loses messages, which limits leave time for
_LONGEST_S: Final = 100 * DAY_S


@dataclass(frozen=True, slots=True)
class Autonomy:
    """A way of commanding, which a study compares with others."""

    name: str  # as tables call it
    level: Literal["mission", "waypoint", "short_range_goal", "joint"]  # the mission's `autonomy`
    # the operator's, where the level is `short_range_goal`
    steering: Literal["move_and_wait", "continuous"] = "move_and_wait"
    waits: bool = True  # the operator sends nothing more until it knows how its last command ended


MISSION: Final = Autonomy("mission", "mission")
WAYPOINT: Final = Autonomy("waypoint", "waypoint")
SHORT_RANGE_GOAL: Final = Autonomy("short_range_goal", "short_range_goal")
CONTINUOUS: Final = Autonomy("short_range_goal-continuous", "short_range_goal", "continuous", waits=False)
JOINT: Final = Autonomy("joint", "joint", waits=False)

AUTONOMIES: Final = {one.name: one for one in (MISSION, WAYPOINT, SHORT_RANGE_GOAL, CONTINUOUS, JOINT)}


def autonomies_of(names: Sequence[str]) -> list[str]:
    """Return names of autonomies in the order of AUTONOMIES, each once.

    Raises:
        InputError: there is none of a name.
    """
    if unknown := [name for name in names if name not in AUTONOMIES]:
        problem = f"--autonomy: {unknown[0]!r} is not an autonomy; choose from {', '.join(AUTONOMIES)}"
        raise InputError(problem, hint="Separate several by commas, as in --autonomy mission,waypoint.")
    return [name for name in AUTONOMIES if name in names]


@dataclass(frozen=True, slots=True, order=True)
class DelayCase:
    """One flight: nothing else decides how it goes but the policy, the route and the operator's think time."""

    route: str  # its name
    autonomy: str  # its name
    rtt_s: float  # the link's round trip, half of it each way
    # the mission's. Flights with one seed start in the same posture however they are commanded, so that what
    # differs between two autonomies or two round trips is the delay
    seed: int


def grid(
    routes: Iterable[str], autonomies: Iterable[str], rtts_s: Sequence[float], seeds: Sequence[int]
) -> list[DelayCase]:
    """Return a case for each combination, the seeds innermost."""
    return [DelayCase(*key) for key in itertools.product(routes, autonomies, rtts_s, seeds)]


def fine_grid(routes: Iterable[str], seeds: Sequence[int]) -> list[DelayCase]:
    """Return the cases of the finer sweep, which find out where `joint` fails."""
    return grid(routes, [JOINT.name], FINE_RTTS_S, seeds)


def mission_of(route: Mission, case: DelayCase, think_s: float | None = None) -> Mission:
    """Return the mission of a case: the route with its delay, its autonomy, its seed and its time limits.

    Limits grow with the round trip, and with what the link loses and lets wait: they are there for a robot that has
    lost its way, not to end the study's longest flights. All else is the route's own.

    Args:
        route: that `refuse_what_is_not_kept` has let pass.
        case: of the study.
        think_s: in place of the route's own think time [s].
    """
    autonomy = AUTONOMIES[case.autonomy]
    think_s = route.operator.think_s if think_s is None else think_s
    allowance_s = _exchanges_of_a_leg(route) * (_exchange_s(route, case.rtt_s) + think_s)
    limits_s = {leg.at: min(leg.timeout_s + allowance_s, DAY_S) for leg in route.legs()}
    waypoints = [
        waypoint.model_copy(update={"timeout_s": limits_s.get(at, waypoint.timeout_s)})
        for at, waypoint in enumerate(route.waypoints)
    ]
    longest_s = sum(limits_s[leg.at] + leg.hold_s for leg in route.legs()) + allowance_s
    return route.model_copy(
        update={
            "seed": case.seed,
            "autonomy": autonomy.level,
            "operator": route.operator.model_copy(update={"steering": autonomy.steering, "think_s": think_s}),
            "link": with_round_trip(route.link, case.rtt_s),
            "waypoints": tuple(waypoints),
            "expect": route.expect.model_copy(update={"max_time_s": min(longest_s, _LONGEST_S)}),
        }
    )


def _exchanges_of_a_leg(route: Mission) -> int:
    """Return how often the operator may command during the longest leg: twice the number of its short-range goals."""
    places = [route.start.position_m, *((leg.x_m, leg.y_m) for leg in route.legs())]
    longest_m = max(math.dist(a, b) for a, b in itertools.pairwise(places))
    return 2 * math.ceil(longest_m / route.operator.lookahead_m) + 2


def _exchange_s(route: Mission, rtt_s: float) -> float:
    """Return how long a command and its answer may take over a route's link with another round trip [s]."""
    link, commands = route.link, route.commands
    sends = min(1 + commands.retries, _MOST_SENDS) if link.up.loss or link.down.loss else 1
    waits_s = 0.0
    for way in (link.up, link.down):
        contacts = contacts_of(way, route.files)
        waits_s += seconds(contacts.longest_gap_ns + (contacts.next_open_ns(0) or 0))
        if way.rate_bps is not None:
            waits_s += way.queue_bytes * 8 / way.rate_bps
    return sends * rtt_s + (sends - 1) * commands.margin_s + waits_s
