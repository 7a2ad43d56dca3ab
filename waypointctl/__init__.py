"""Mission control for learned waypoint policies: train one, fly it over a slow link, prove the log.

    import waypointctl

    result = waypointctl.fly("missions/ten-second.yaml", policy="ant-waypoint", log="out.mcap")
    print(result.outcome, waypointctl.verify("out.mcap").verdict.name)
    with waypointctl.open_log("out.mcap") as log:
        position = log.arrays("/state")["qpos"][:, :2]

This page is the public API: `__all__`. Each name is loaded when it is first used, so that `import waypointctl` loads
neither numpy, pydantic, mujoco nor torch.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

__version__ = "0.2.0"

if TYPE_CHECKING:
    from waypointctl.errors import (
        InputError,
        LogError,
        MissionError,
        OutputError,
        PolicyError,
        RecipeError,
        RobotError,
        SuiteError,
        WaypointctlError,
    )
    from waypointctl.evaluation.evaluate import evaluate
    from waypointctl.evaluation.result import CaseResult, Evaluation
    from waypointctl.evaluation.suite import Suite, load_suite
    from waypointctl.flight.fly import fly
    from waypointctl.flight.navigator import Navigator
    from waypointctl.flight.outcome import FlightResult
    from waypointctl.flight.sink import Sink
    from waypointctl.log import messages
    from waypointctl.mission.files import MissionFile, load_mission
    from waypointctl.mission.mission import Mission
    from waypointctl.policy.bundle import LoadedPolicy, load_policy
    from waypointctl.policy.protocol import Policy, PolicyState
    from waypointctl.replay.command_summary import CommandSummary
    from waypointctl.replay.flight_log import FlightLog, open_log
    from waypointctl.replay.legs import WaypointStatus, WaypointSummary
    from waypointctl.replay.link_summary import LinkSummary
    from waypointctl.replay.summary import FlightSummary
    from waypointctl.replay.track import Effort, Track
    from waypointctl.replay.verify import Verdict, Verification, verify
    from waypointctl.robots.load import load_robot
    from waypointctl.robots.robot import Robot
    from waypointctl.task.batched import BatchedWaypointEnv, Step
    from waypointctl.task.config import TaskConfig
    from waypointctl.task.env import WaypointEnv
    from waypointctl.task.plugins import (
        ObservationGroup,
        Plugins,
        RewardTerm,
        load_plugins,
        observation_group,
        reward_term,
    )
    from waypointctl.task.reward import RewardWeights
    from waypointctl.task.view import SimulationView
    from waypointctl.training.recipe import Recipe
    from waypointctl.training.recipe_file import RecipeFile, load_recipe
    from waypointctl.training.train import TrainingResult, train

__all__ = [
    "BatchedWaypointEnv",
    "CaseResult",
    "CommandSummary",
    "Effort",
    "Evaluation",
    "FlightLog",
    "FlightResult",
    "FlightSummary",
    "InputError",
    "LinkSummary",
    "LoadedPolicy",
    "LogError",
    "Mission",
    "MissionError",
    "MissionFile",
    "Navigator",
    "ObservationGroup",
    "OutputError",
    "Plugins",
    "Policy",
    "PolicyError",
    "PolicyState",
    "Recipe",
    "RecipeError",
    "RecipeFile",
    "RewardTerm",
    "RewardWeights",
    "Robot",
    "RobotError",
    "SimulationView",
    "Sink",
    "Step",
    "Suite",
    "SuiteError",
    "TaskConfig",
    "Track",
    "TrainingResult",
    "Verdict",
    "Verification",
    "WaypointEnv",
    "WaypointStatus",
    "WaypointSummary",
    "WaypointctlError",
    "__version__",
    "evaluate",
    "fly",
    "load_mission",
    "load_plugins",
    "load_policy",
    "load_recipe",
    "load_robot",
    "load_suite",
    "messages",
    "observation_group",
    "open_log",
    "reward_term",
    "train",
    "verify",
]

_MODULES: Final = {
    "errors": (
        "InputError",
        "LogError",
        "MissionError",
        "OutputError",
        "PolicyError",
        "RecipeError",
        "RobotError",
        "SuiteError",
        "WaypointctlError",
    ),
    "evaluation.evaluate": ("evaluate",),
    "evaluation.result": ("CaseResult", "Evaluation"),
    "evaluation.suite": ("Suite", "load_suite"),
    "flight.fly": ("fly",),
    "flight.navigator": ("Navigator",),
    "flight.outcome": ("FlightResult",),
    "flight.sink": ("Sink",),
    "mission.files": ("MissionFile", "load_mission"),
    "mission.mission": ("Mission",),
    "policy.bundle": ("LoadedPolicy", "load_policy"),
    "policy.protocol": ("Policy", "PolicyState"),
    "replay.command_summary": ("CommandSummary",),
    "replay.flight_log": ("FlightLog", "open_log"),
    "replay.legs": ("WaypointStatus", "WaypointSummary"),
    "replay.link_summary": ("LinkSummary",),
    "replay.summary": ("FlightSummary",),
    "replay.track": ("Effort", "Track"),
    "replay.verify": ("Verdict", "Verification", "verify"),
    "robots.load": ("load_robot",),
    "robots.robot": ("Robot",),
    "task.batched": ("BatchedWaypointEnv", "Step"),
    "task.config": ("TaskConfig",),
    "task.env": ("WaypointEnv",),
    "task.reward": ("RewardWeights",),
    "task.plugins": ("ObservationGroup", "Plugins", "RewardTerm", "load_plugins", "observation_group", "reward_term"),
    "task.view": ("SimulationView",),
    "training.recipe": ("Recipe",),
    "training.recipe_file": ("RecipeFile", "load_recipe"),
    "training.train": ("TrainingResult", "train"),
}


def __getattr__(name: str) -> Any:
    for module, names in _MODULES.items():
        if name in names:
            globals()[name] = getattr(import_module(f"waypointctl.{module}"), name)
            return globals()[name]
    if name == "messages":
        return import_module("waypointctl.log.messages")
    raise AttributeError(f"module 'waypointctl' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
