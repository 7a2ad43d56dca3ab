"""THE loop: a mission flown, tick by tick, with the link between operator and robot."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from waypointctl.errors import MissionError, RobotError, given_path, wrong_type
from waypointctl.flight.flight import Flight
from waypointctl.flight.header import flight_header
from waypointctl.flight.navigator import Navigator
from waypointctl.flight.operator.console import LineSource
from waypointctl.flight.operator.requests import planned_waypoints
from waypointctl.flight.outcome import FlightResult
from waypointctl.flight.policy_fit import refuse_misfit, reward_weights
from waypointctl.flight.sink import OnboardCamera, Sink, tee, with_pictures
from waypointctl.log.writer import LogWriter
from waypointctl.mission.files import MissionFile, dump_mission, load_mission
from waypointctl.mission.mission import Mission
from waypointctl.paths import MCAP, refuse_other_content
from waypointctl.policy.bundle import policy_of
from waypointctl.policy.protocol import Policy
from waypointctl.robots.load import given_robot, load_robot
from waypointctl.robots.robot import Robot
from waypointctl.task.plugins import Plugins, load_plugins


def fly(
    mission: Mission | MissionFile | Path | str,
    policy: Policy | Path | str | None = None,
    sink: Sink | None = None,
    *,
    log: Path | str | None = None,
    seed: int | None = None,
    pictures: bool = False,
    robot: Robot | Path | str | None = None,
    console: LineSource | None = None,
    navigator: Navigator | None = None,
    plugins: Plugins = (),
    interrupted: Callable[[], bool] = lambda: False,
) -> FlightResult:
    """Fly a mission to its end.

    The same mission, policy and seed give the same messages, bit for bit, and the same log, byte for byte.

    Args:
        mission: a mission, or the path of its file.
        policy: the policy that drives the robot: itself, its folder, or its name; the mission's unless given.
        sink: called with each message, as it happens.
        log: path of an MCAP file to write; a log that is there is replaced. It is called LOG.part until it is whole.
        seed: of all random streams; the mission's unless given.
        pictures: add a picture to the messages for each observation of the mission, where something can draw.
        robot: in place of the mission's: itself, its folder, or its name.
        console: the source of a person's commands.
        navigator: gives the policy its goals; straight to the plan's waypoints unless given. A log names its class and
            does not hold it: such a log cannot be verified.
        plugins: observation groups and reward terms that the policy was trained with and that are not built in:
            themselves, or the paths of their Python files, which are executed. A log names them and does not hold them.
        interrupted: called before every control step; True ends the flight.

    Raises:
        MissionError: the mission is wrong, or a file that it refers to.
        RobotError: there is no such robot, or it is wrong.
        PolicyError: the policy is missing, damaged, or made for another robot, layout or control period; or it
            observes a group that is neither built in nor in `plugins`.
        OutputError: the log cannot be written.
        InputError: an argument has a wrong type, or a plugin has the name of another one, or fails.
    """
    _refuse_wrong_types(sink, navigator)
    log = None if log is None else given_path("log", log, "an MCAP file")
    file = _mission_file(mission, seed, logged=log is not None)
    driver = policy_of(file.policy_path if policy is None else policy)
    robot = robot_of(file) if robot is None else given_robot(robot)
    plugins = load_plugins(plugins)
    refuse_misfit(driver, robot, plugins)
    reward_weights(driver, plugins)  # refused here, a policy leaves no log behind
    with ExitStack() as stack:
        sinks = [] if sink is None else [sink]
        if log is not None:
            refuse_other_content(log, MCAP, "a log")
            header = flight_header(file, driver, robot, navigator, plugins)
            sinks.insert(0, stack.enter_context(LogWriter(log, header)))
        camera = stack.enter_context(OnboardCamera(robot, planned_waypoints(file.mission)))
        take = with_pictures(tee(*sinks), camera) if pictures else tee(*sinks)
        result = _to_the_end(Flight(file.mission, driver, take, robot, console, navigator, plugins), interrupted)
    result = replace(result, pictures=camera.taken, no_pictures=camera.trouble)
    return result if log is None else result.logged(log)


def _refuse_wrong_types(sink: Sink | None, navigator: Navigator | None) -> None:
    if sink is not None and not callable(sink):
        raise wrong_type("sink", sink, "what is called with each message")
    if navigator is not None and not callable(getattr(navigator, "goals", None)):
        raise wrong_type("navigator", navigator, "a Navigator")


def _to_the_end(flight: Flight, interrupted: Callable[[], bool]) -> FlightResult:
    flight.begin()
    while True:
        flight.exchange()
        flight.read_console()
        flight.sense()
        flight.exchange()
        if flight.over:
            return flight.end()
        if interrupted():
            return flight.interrupt()
        flight.act()


def _mission_file(mission: Mission | MissionFile | Path | str, seed: int | None, *, logged: bool) -> MissionFile:
    if isinstance(mission, Path | str):
        mission = load_mission(mission)
    elif isinstance(mission, Mission):
        source = dump_mission(mission).encode() if logged else b""
        mission = MissionFile(mission, source, Path(f"{mission.name}.yaml"))
    elif not isinstance(mission, MissionFile):
        raise wrong_type("mission", mission, "a Mission, a MissionFile, or the path of a mission file")
    if seed is not None and not (isinstance(seed, int) and 0 <= seed < 2**63):
        raise MissionError(f"a seed is a whole number from 0 to 2^63 - 1, not {seed!r}")
    return mission if seed is None else replace(mission, mission=mission.mission.model_copy(update={"seed": seed}))


def robot_of(file: MissionFile) -> Robot:
    """Return the robot of a mission.

    Raises:
        RobotError: there is no such robot, or it is wrong.
    """
    try:
        return load_robot(file.mission.robot)
    except RobotError as error:
        if error.where is not None:
            raise
        raise RobotError(f"robot: {error.problem}", where=file.place("robot"), hint=error.hint) from error
