from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from tests.conftest import describe
from waypointctl.policy.manifest import FileRecord, Manifest
from waypointctl.training.recipe_file import trained_on

REST = "name: a\nobservation: state\nphases: [{steps: 10}]\n"


def manifest(recipe: str) -> Manifest:
    described = describe()
    training = described.training.model_copy(update={"recipe_sha256": hashlib.sha256(recipe.encode()).hexdigest()})
    files = {name: FileRecord(sha256="0" * 64, size=0) for name in ("policy.onnx", "weights.safetensors")}
    return Manifest(**{**dict(described), "training": training}, files=files)


@pytest.mark.parametrize(
    ("course", "training"),
    [
        ("course: {cases: [[[10 m, 10 m]]]}\n", "single point"),
        ("course: {cases: [[[10, 10]], [[10, 10], [10, 10]]]}\n", "single point"),
        ("course: {cases: [[[10, 10], [4, 4]]]}\n", "waypoints"),
        ("course: {cases: [[[10, 10]], [[4, 4]]]}\n", "waypoints"),
        ("course: {perimeter: square, side: 5 m}\n", "waypoints"),
        ("", "waypoints"),
        ("course: {perimeter: cube}\n", None),
    ],
)
def test_the_recipe_says_what_it_was(tmp_path: Path, course: str, training: str | None) -> None:
    (tmp_path / "train.yaml").write_text(REST + course)
    assert trained_on(tmp_path, manifest(REST + course)) == training


def test_another_recipe_or_none_says_nothing(tmp_path: Path) -> None:
    assert trained_on(tmp_path, manifest(REST)) is None
    (tmp_path / "train.yaml").write_text(REST + "seed: 1\n")
    assert trained_on(tmp_path, manifest(REST)) is None
