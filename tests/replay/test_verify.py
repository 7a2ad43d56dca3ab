from __future__ import annotations

import itertools
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tests.golden.recording import MISSIONS
from tests.replay.rewriting import MISSION, Flown, fly_once
from tests.shipped import shipped_flight
from tests.sim.bare import BareWorld
from waypointctl.flight.fly import fly
from waypointctl.flight.header import MJB
from waypointctl.log.messages import (
    Ack,
    Action,
    Checkpoint,
    Command,
    CommandStage,
    Event,
    Observation,
    Reward,
    State,
    Telemetry,
)
from waypointctl.log.reader import open_log
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.verify import Verdict, verify

REPOSITORY = Path(__file__).parents[2]
LONG = MISSION.replace(b"timeout: 600 ms", b"timeout: 10.5 s")


@pytest.fixture(scope="module")
def policy(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> LoadedPolicy:
    return make_policy(tmp_path_factory.mktemp("policy") / "tiny", seed=7, gain=1.0)


def test_a_flight_is_replayed_exactly(flown: Flown) -> None:
    found = verify(flown.path)
    messages = flown.messages
    assert (found.verdict, found.first_divergence) == (Verdict.EXACT, None), found.reason
    assert found.steps == sum(isinstance(message, Action) for message in messages) > 50
    assert {type(m) for m in messages} == {
        State,
        Observation,
        Action,
        Reward,
        Command,
        CommandStage,
        Ack,
        Telemetry,
        Event,
        Checkpoint,
    }
    states = sum(isinstance(message, State) for message in messages)
    assert found.checks[0].startswith(f"{states} states")


def test_a_log_written_again_from_its_messages_is_the_same_bytes(flown: Flown, tmp_path: Path) -> None:
    assert flown.rewritten(tmp_path / "again.mcap").read_bytes() == flown.path.read_bytes()


def test_a_bare_mj_step_loop_on_the_logs_model_reproduces_every_logged_state(flown: Flown) -> None:
    mjb = open_log(flown.path).attachments[MJB]
    world = BareWorld(mujoco.MjModel.from_binary_path("model.mjb", {"model.mjb": mjb}))
    messages = flown.messages
    states = [message for message in messages if isinstance(message, State)]
    actions = [message for message in messages if isinstance(message, Action)]
    world.place(states[0].qpos, states[0].qvel)
    for action, state in zip(actions, states[1:], strict=True):
        world.step(action.applied)
        np.testing.assert_array_equal(world.data.qpos, state.qpos)
        np.testing.assert_array_equal(world.data.qvel, state.qvel)
        np.testing.assert_array_equal(world.data.qacc_warmstart, state.qacc_warmstart)


def test_a_bare_loop_can_begin_at_a_checkpoint(tmp_path: Path, policy: LoadedPolicy) -> None:
    messages = fly_once(tmp_path, policy, LONG).messages
    checkpoint = [message for message in messages if isinstance(message, Checkpoint)][-1]
    assert checkpoint.time_ns == 10_000_000_000
    world = BareWorld()
    mujoco.mj_setState(world.model, world.data, checkpoint.integration, mujoco.mjtState.mjSTATE_INTEGRATION)
    states = {message.step: message for message in messages if isinstance(message, State)}
    actions = [m for m in messages if isinstance(m, Action) and m.step >= checkpoint.step]
    assert len(actions) > 20
    for action in actions:
        world.step(action.applied)
        np.testing.assert_array_equal(world.data.qpos, states[action.step + 1].qpos)
        np.testing.assert_array_equal(world.data.qacc_warmstart, states[action.step + 1].qacc_warmstart)


@pytest.mark.parametrize("steps", [0, 1, 2, 3, 40])
def test_an_interrupted_flight_is_replayed_exactly(tmp_path: Path, policy: LoadedPolicy, steps: int) -> None:
    asked = itertools.count()
    flown = fly_once(tmp_path, policy, interrupted=lambda: next(asked) == steps)
    assert sum(isinstance(message, Action) for message in flown.messages) == steps
    found = verify(flown.path)
    assert (found.verdict, found.steps) == (Verdict.EXACT, steps), found.reason


def test_a_seed_that_was_given_at_the_command_line_is_the_one_replayed(tmp_path: Path, policy: LoadedPolicy) -> None:
    flown = fly_once(tmp_path, policy, MISSION.replace(b"seed: 4", b"seed: 5"))
    mission_file = flown.mission_file
    other = mission_file.mission.model_copy(update={"seed": 123})
    path = tmp_path / "other.mcap"
    result = fly(type(mission_file)(other, mission_file.source, mission_file.path), policy, log=path)
    assert result.seed == 123
    assert verify(path).verdict is Verdict.EXACT


def test_the_log_is_enough(tmp_path: Path, make_policy: Callable[..., LoadedPolicy]) -> None:
    kept, flight = tmp_path / "kept", tmp_path / "flight"
    kept.mkdir()
    flight.mkdir()
    flown = fly_once(flight, make_policy(flight / "policy", seed=7))
    shutil.move(flown.path, kept / "only.mcap")
    shutil.rmtree(flight)
    program = (
        "from pathlib import Path; from waypointctl.replay.verify import verify\n"
        "print(verify(Path('only.mcap')).verdict)"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=kept, capture_output=True, text=True, check=False)
    assert done.stdout == "exact\n", done.stderr
    assert [path.name for path in kept.iterdir()] == ["only.mcap"], "and it leaves nothing behind"


# Of each autonomy one, and what else a replay does otherwise: pictures, a console's kind of commands, losses, contacts.
QUICK = ("contact-plan", "hold-and-resume", "lan-joint", "lossy-link", "observe-stops", "steered")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[] if name in QUICK else pytest.mark.slow) for name in MISSIONS]
)
def test_every_shipped_mission_is_replayed_exactly(name: str) -> None:
    found = verify(shipped_flight(name)[1])
    assert found.verdict is Verdict.EXACT, found.reason


@pytest.mark.parametrize("name", MISSIONS)
def test_every_shipped_mission_succeeds(name: str) -> None:
    assert shipped_flight(name)[0]["outcome"] == "success"


def test_what_there_was_one_of_is_said_as_one(flown: Flown) -> None:
    said = " ".join(verify(flown.path).checks)
    counts = {kind: sum(isinstance(m, kind) for m in flown.messages) for kind in (Command, Checkpoint)}
    for kind, count in counts.items():
        assert re.search(rf"\b{count} {kind.__name__.lower()}{'' if count == 1 else 's'}\b", said)
    assert not re.search(r"\b1 \w+s\b", said)
