"""The proof covers the file, not only the messages that are flown again; and holds on other float kernels."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.replay.rewriting import Flown
from waypointctl.log.foxglove.view import FoxgloveView, Frame
from waypointctl.log.messages import Message
from waypointctl.replay.verdict import Verdict
from waypointctl.replay.verify import verify

SHIPPED_MISSION = Path(__file__).parents[2] / "missions" / "yard-loop.yaml"


@pytest.mark.parametrize(
    "forged",
    [{"mission": "another"}, {"autonomy": "bogus"}, {"control_period_ns": "7"}, {"reward_terms": "?"}, {"more": "1"}],
    ids=lambda forged: next(iter(forged)),
)
def test_forged_metadata_diverge(flown: Flown, tmp_path: Path, forged: dict[str, str]) -> None:
    found = verify(flown.rewritten(tmp_path / "forged.mcap", metadata=forged))
    assert found.verdict is Verdict.DIVERGED
    assert found.first_divergence is not None
    assert (found.first_divergence.topic, found.first_divergence.component) == ("metadata", next(iter(forged)))


def test_an_attachment_that_was_not_there_diverges(flown: Flown, tmp_path: Path) -> None:
    found = verify(flown.rewritten(tmp_path / "forged.mcap", attachments={"policy/weights.safetensors": None}))
    assert found.verdict is not Verdict.EXACT


@pytest.mark.parametrize("topic", ["/tf", "/odometry", "/joints", "/log", "/path", "/scene"])
def test_a_viewers_topic_that_was_changed_diverges(
    flown: Flown, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, topic: str
) -> None:
    seen = FoxgloveView.__call__

    def changed(self: FoxgloveView, message: Message) -> list[Frame]:
        frames = list(seen(self, message))
        return [f._replace(data=f.data[:-1] + bytes([f.data[-1] ^ 1])) if f.topic == topic else f for f in frames]

    with monkeypatch.context() as patch:
        patch.setattr(FoxgloveView, "__call__", changed)
        path = flown.rewritten(tmp_path / "forged.mcap")
    found = verify(path)
    assert found.verdict is Verdict.DIVERGED
    assert found.first_divergence is not None
    assert found.first_divergence.topic == topic


def test_what_has_been_compared_is_the_whole_file(flown: Flown) -> None:
    assert "byte for byte" in verify(flown.path).checks[-1]


def test_on_other_float_kernels_the_physics_is_exact_and_the_rest_within_rounding(tmp_path: Path) -> None:
    """Numpy rounds its trigonometry otherwise without AVX-512; where there is none, this repeats the plain proof."""
    log = tmp_path / "flight.mcap"
    command = [sys.executable, "-m", "waypointctl"]
    subprocess.run([*command, "run", str(SHIPPED_MISSION), "--out", str(log)], check=True, capture_output=True)
    plain = os.environ | {"NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR"}
    done = subprocess.run(
        [*command, "replay", "--verify", "--json", str(log)], env=plain, capture_output=True, text=True, check=False
    )
    found = json.loads(done.stdout)
    assert (done.returncode, found["verdict"]) == (0, "exact"), found
