"""How fast a flight is with its full log, on one core, once it has started, and where the time goes.

Run: python bench/flight_speed.py [MISSION.yaml] [--policy DIR] [--rounds 7] [--json]

Flights with their log and flights without take turns. The parts are measured alone, with what the flight gave them:
its actions for the physics, its observations for the network, its messages for the log. Loading is not counted.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time

os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # before any library starts its threads

from waypointctl.flight.fly import fly  # noqa: E402
from waypointctl.flight.header import flight_header  # noqa: E402
from waypointctl.log.messages import Action, Message, Observation, State  # noqa: E402
from waypointctl.log.writer import LogWriter  # noqa: E402
from waypointctl.mission.files import MissionFile, load_mission  # noqa: E402
from waypointctl.policy.bundle import LoadedPolicy, load_policy  # noqa: E402
from waypointctl.robots.load import load_robot  # noqa: E402
from waypointctl.sim.stepping import SingleRobot  # noqa: E402

MISSION = Path(__file__).parents[1] / "missions" / "paper-two-point-moon.yaml"


class Bench:
    """A mission, and each part of its flight as a thing to time."""

    def __init__(self, mission_file: MissionFile, policy: LoadedPolicy, out: Path) -> None:
        """Fly once, to have what the parts need."""
        self._mission_file, self._policy, self._out = mission_file, policy, out
        self._robot = load_robot(mission_file.mission.robot)
        self.messages: list[Message] = []
        self.result = fly(mission_file.mission, policy, self.messages.append, robot=self._robot)
        self._actions = [message for message in self.messages if isinstance(message, Action)]
        self._observations = [message for message in self.messages if isinstance(message, Observation)]
        self._start = next(message for message in self.messages if isinstance(message, State))
        self.steps = len(self._actions)

    def flight(self) -> None:
        """Fly and forget."""
        fly(self._mission_file.mission, self._policy, _forget, robot=self._robot)

    def flight_with_log(self) -> None:
        """Fly as `waypointctl run` does."""
        with LogWriter(self._out, flight_header(self._mission_file, self._policy, self._robot)) as writer:
            fly(self._mission_file.mission, self._policy, writer, robot=self._robot)

    def physics(self) -> None:
        """Step the robot through the flight's actions."""
        plant = SingleRobot(self._robot)
        plant.place(self._start.qpos[None], self._start.qvel[None])
        for action in self._actions:
            plant.step(action.applied[None])

    def network(self) -> None:
        """Ask the network for every action of the flight."""
        for observation in self._observations:
            self._policy.act(observation.values[None])

    def log(self) -> None:
        """Write the flight's messages."""
        with LogWriter(self._out, flight_header(self._mission_file, self._policy, self._robot)) as writer:
            for message in self.messages:
                writer(message)


def _forget(message: Message) -> None:
    """Take a message and keep nothing."""


def timed(work: Callable[[], None]) -> tuple[float, float]:
    """Return the CPU and the wall time [s] of a piece of work."""
    cpu, wall = process_time(), perf_counter()
    work()
    return process_time() - cpu, perf_counter() - wall


def measure(bench: Bench, rounds: int) -> dict[str, float]:
    parts = {
        "flight_with_log": bench.flight_with_log,
        "flight": bench.flight,
        "physics": bench.physics,
        "network": bench.network,
        "log": bench.log,
    }
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in parts}
    for _ in range(rounds):
        for name, work in parts.items():
            times[name].append(timed(work))
    simulated_s = bench.steps * 0.02
    cpu_s = {name: statistics.median(cpu for cpu, _ in each) for name, each in times.items()}
    wall_s = {name: statistics.median(wall for _, wall in each) for name, each in times.items()}
    return {
        "simulated_s": round(simulated_s, 2),
        "steps": bench.steps,
        "messages": len(bench.messages),
        **{f"{name}_us_per_step": round(cpu_s[name] / bench.steps * 1e6, 1) for name in parts},
        "times_real_time_cpu": round(simulated_s / cpu_s["flight_with_log"], 1),
        "times_real_time_wall": round(simulated_s / wall_s["flight_with_log"], 1),
        "times_real_time_without_log_cpu": round(simulated_s / cpu_s["flight"], 1),
        "times_real_time_without_log_wall": round(simulated_s / wall_s["flight"], 1),
    }


def print_table(found: dict[str, float]) -> None:
    print(f"{found['simulated_s']} s simulated, {found['steps']} steps, {found['messages']} messages, one core")
    for name, key in (("with its full log", ""), ("without log", "_without_log")):
        cpu, wall = found[f"times_real_time{key}_cpu"], found[f"times_real_time{key}_wall"]
        print(f"  {name:20} {cpu:>7.1f} x real time by CPU, {wall:>7.1f} x by the clock")
    print("  CPU a control step")
    rows = (("flight_with_log", "flight with its log"), ("flight", "  flight without"), ("log", "  the log alone"))
    for key, name in (*rows, ("physics", "  the physics alone"), ("network", "  the network alone")):
        print(f"  {name:20} {found[f'{key}_us_per_step']:>7.1f} us")


def main() -> None:
    parser = argparse.ArgumentParser(description="The speed of a flight with its full log, on one core.")
    parser.add_argument("mission", type=Path, nargs="?", default=MISSION)
    parser.add_argument("--policy", type=Path, help="not the mission's")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    mission_file = load_mission(options.mission)
    policy = load_policy(options.policy or mission_file.policy_path)
    with tempfile.TemporaryDirectory() as folder:
        found = measure(Bench(mission_file, policy, Path(folder) / "flight.mcap"), options.rounds)
    if options.json:
        print(json.dumps(found, indent=2))
    else:
        print_table(found)


if __name__ == "__main__":
    main()
