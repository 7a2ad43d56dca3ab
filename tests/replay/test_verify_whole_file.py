"""The proof covers the file, not only the messages that are flown again; and holds on other float kernels."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.replay.rewriting import Flown, altered
from waypointctl.flight.header import platform_facts
from waypointctl.log.foxglove.view import FoxgloveView, Frame
from waypointctl.log.messages import Action, Message, Observation, Telemetry
from waypointctl.replay.contents import PROGRAM
from waypointctl.replay.verify import Verdict, verify

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
@pytest.mark.parametrize("named", [{}, {"source": "0" * 12}, {"version_numpy": "1.0"}], ids=["", "source", "numpy"])
def test_a_viewers_topic_that_was_changed_diverges_on_every_program(
    flown: Flown, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, topic: str, named: dict[str, str]
) -> None:
    seen = FoxgloveView.__call__

    def changed(self: FoxgloveView, message: Message) -> list[Frame]:
        frames = list(seen(self, message))
        return [flipped(frame) if frame.topic == topic else frame for frame in frames]

    with monkeypatch.context() as patch:
        patch.setattr(FoxgloveView, "__call__", changed)
        path = flown.rewritten(tmp_path / "forged.mcap", metadata=named)
    found = verify(path)
    assert found.verdict is Verdict.DIVERGED
    assert found.first_divergence is not None
    assert found.first_divergence.topic == topic


def flipped(frame: Frame) -> Frame:
    """Return a viewers' message with its last bit the other way round."""
    return frame._replace(data=frame.data[:-1] + bytes([frame.data[-1] ^ 1]))


@pytest.mark.parametrize("key", PROGRAM)
def test_another_program_or_processor_lowers_the_verdict_and_is_named(flown: Flown, tmp_path: Path, key: str) -> None:
    found = verify(flown.rewritten(tmp_path / "elsewhere.mcap", metadata={key: "0.0"}))
    assert (found.verdict, found.first_divergence) == (Verdict.EQUIVALENT, None)
    (line,) = found.not_compared
    assert line == (
        f"the program and processor named in the log: {PROGRAM[key]} was 0.0 and is {platform_facts()[key]}"
    )
    assert "byte for byte" in found.checks[-1]


@pytest.mark.parametrize(
    ("kind", "field", "bit"), [(Action, "commanded", 20), (Observation, "values", 20), (Telemetry, "x_m", 20)]
)
@pytest.mark.parametrize("key", ["source", "version_zstandard"])
def test_only_other_float_kernels_may_round_otherwise(
    flown: Flown, tmp_path: Path, key: str, kind: type[Any], field: str, bit: int
) -> None:
    messages = flown.messages
    at = next(i for i, message in enumerate(messages) if isinstance(message, kind))
    messages[at] = altered(messages[at], field, 0, bit)
    found = verify(flown.rewritten(tmp_path / "forged.mcap", messages, metadata={key: "0.0"}))
    assert found.verdict is Verdict.DIVERGED


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
    assert done.returncode == 0
    assert found["verdict"] in ("exact", "equivalent", "approximate"), found
