"""What is right, to be damaged: a small policy, an evaluation of it, a flight, a model of stable-baselines3."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from tests.conftest import describe, random_network
from tests.hostile.bundles import Sound
from waypointctl.policy.write import bundle_files


def sound_files(folder: Path) -> Sound:
    """Return a policy with random weights, and an evaluation that could be of it."""
    network = random_network((31, 8, 8, 8))
    files = bundle_files(describe(), network.to_onnx(), network.to_safetensors())
    case = {
        "name": "a", "waypoints": [[1.0, 2.0]], "trials": 4, "successes": 3, "rate": 0.75, "wilson95": [0.3, 0.95],
        "falls": 1, "timeouts": 0, "mean_time_s": 2.0, "spl": 0.7, "paper": None, "legs": 4, "legs_reached": 3,
        "mean_leg_time_s": 2.0, "mean_speed_mps": 1.5,
    }  # fmt: skip
    evaluation = {
        "policy": "tiny", "suite": "region", "seed": 1, "cases": [case], "acceptance": {"shape": "box", "size_m": 0.5},
        "deadline": {"first_s": 10.0, "further_s": 20.0}, "policy_sha256": "0" * 64, "versions": {"numpy": "2"},
    }  # fmt: skip
    return Sound(files, evaluation)


def sound_log(folder: Path, sound: Sound) -> Sound:
    """Return the same with a flight of the policy."""
    from tests.replay.rewriting import fly_once
    from waypointctl.policy.bundle import load_policy_bytes
    from waypointctl.robots.load import load_robot

    folder.mkdir(parents=True, exist_ok=True)
    flown = fly_once(folder, load_policy_bytes(sound.policy, "policy"))
    return replace(sound, more=sound.more | {"flown": flown, "mjb": load_robot("ant").to_mjb()})


def sound_archive(folder: Path, sound: Sound) -> Sound:
    """Return the same with a model that stable-baselines3 saved, and its VecNormalize."""
    from stable_baselines3 import PPO

    from tests.training.sb3_models import normalised_env

    env = normalised_env()
    PPO("MlpPolicy", env, policy_kwargs={"net_arch": [8]}, n_steps=64, device="cpu").save(folder / "model.zip")
    env.save(str(folder / "normaliser.pkl"))
    files = {"model": (folder / "model.zip").read_bytes(), "normaliser": (folder / "normaliser.pkl").read_bytes()}
    return replace(sound, more=sound.more | files)
