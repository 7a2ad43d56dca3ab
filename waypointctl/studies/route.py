"""The routes that a study flies: missions that come with waypointctl, or anybody's."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import Final

from waypointctl.errors import InputError, MissionError
from waypointctl.mission.files import MissionFile, load_mission, parse_mission

BUILT_IN: Final = ("two-point", "ten-point", "short")


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
        raise InputError(f"--route: {twice[0]!r} is the name of more than one", hint="Give each mission its own name.")
    return {route.mission.name: route for route in routes}
