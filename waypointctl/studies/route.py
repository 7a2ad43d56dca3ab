"""The routes that a study flies, missions of the package or of a user, and their links with another round trip.

A round trip is shared between the two ways as the mission shares it: a link with 1 s up and 3 s down has a quarter of
each round trip on the way up. Where the mission has no delay, or takes it from a contact plan, each way has half.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Final

from waypointctl.errors import InputError, MissionError
from waypointctl.mission.files import MissionFile, load_mission, parse_mission
from waypointctl.mission.link import DelayAt, Link, LinkDirection
from waypointctl.mission.mission import Mission

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
