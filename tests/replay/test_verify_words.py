"""What a proof says it compared is what is in the log."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from tests.replay.rewriting import Flown
from waypointctl.flight import header
from waypointctl.policy.network import Network
from waypointctl.replay import contents
from waypointctl.replay.verify import Verdict, verification_json, verify


def test_commands_their_stages_and_what_was_heard_are_counted(flown: Flown) -> None:
    counts = Counter(type(message).__name__ for message in flown.messages)
    assert counts["CommandStage"] > counts["Command"] > 1
    said = (
        f"{counts['Command']} commands, {counts['CommandStage']} command stages, {counts['Ack']} acknowledgements and "
        f"{counts['Telemetry']} telemetry frames, with their delivery times"
    )
    checks = verify(flown.path).checks
    assert said in checks
    assert counts["Checkpoint"] == 1
    assert any(line.startswith("1 checkpoint,") for line in checks)
    assert any(line.endswith(", recomputed by the network") for line in checks)
    assert not any("typed at the console" in line for line in checks)


def test_what_is_reproduced_is_so_within_rounding_at_least(flown: Flown, tmp_path: Path) -> None:
    assert {verdict for verdict in Verdict if verdict.is_reproduced} == {
        Verdict.EXACT,
        Verdict.EQUIVALENT,
        Verdict.APPROXIMATE,
    }
    assert verification_json(verify(flown.path))["first_divergence"] is None
    short = verification_json(verify(flown.rewritten(tmp_path / "short.mcap", flown.messages[:-1])))
    where = short["first_divergence"]
    assert isinstance(where, dict)
    assert where["component"] == "end"


@pytest.mark.parametrize("version", ["", "0.0.1"])
def test_another_program_is_named_as_what_may_have_caused_a_divergence(
    flown: Flown, tmp_path: Path, version: str
) -> None:
    metadata = {"version_waypointctl": version} if version else {}
    found = verify(flown.rewritten(tmp_path / "short.mcap", flown.messages[:-1], metadata=metadata))
    assert found.verdict is Verdict.DIVERGED
    assert found.reason.startswith("diverged ")
    assert ("the other program may be the cause" in found.reason) is bool(version)
    assert version in found.reason
    assert found.steps > 50, "what was compared before"


def test_a_network_that_rounds_otherwise_on_another_processor_is_said_to(
    flown: Flown, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, run = dict(header.platform_facts()), Network.run
    monkeypatch.setattr(contents, "platform_facts", lambda: here | {"processor": "another one"})
    monkeypatch.setattr(Network, "run", lambda network, observation: np.nextafter(run(network, observation), 2.0))
    found = verify(flown.path)
    assert found.verdict is Verdict.APPROXIMATE
    count, text = found.not_compared[0].split(" ", 1)
    assert text == "actions of the network: equal within 1e-05, not bit for bit"
    assert 1 < int(count) < found.steps, "of those that are not at their limit"


def test_a_log_that_cannot_be_verified_was_not_compared(flown: Flown, tmp_path: Path) -> None:
    elsewhere = verify(flown.rewritten(tmp_path / "other.mcap", metadata={"version_mujoco": "2.3.7"}))
    unusable = verify(flown.rewritten(tmp_path / "many.mcap", metadata={"seed": "many"}))
    for found in (elsewhere, unusable):
        assert (found.verdict, found.steps, found.first_divergence) == (Verdict.UNVERIFIABLE, 0, None)
