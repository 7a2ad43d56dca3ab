"""Weights that are not those of the network are told from those that are."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import load, save

from tests.conftest import random_network
from waypointctl.policy.manifest import NETWORK, WEIGHTS
from waypointctl.policy.network import weights_fault

NET = random_network((31, 8, 8, 8), seed=3)
ONNX, TENSORS = NET.to_onnx(), NET.to_safetensors()


def with_header(header: object, data: bytes = b"") -> bytes:
    text = json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + data


@pytest.mark.parametrize(
    "folder", sorted((Path(__file__).parents[2] / "policies").iterdir()), ids=lambda folder: folder.name
)
def test_those_of_every_shipped_policy_are(folder: Path) -> None:
    assert weights_fault((folder / WEIGHTS).read_bytes(), (folder / NETWORK).read_bytes()) == ""


def test_in_either_precision_and_orientation() -> None:
    assert weights_fault(TENSORS, ONNX) == ""
    turned = {name: np.ascontiguousarray(array.T).astype(np.float32) for name, array in load(TENSORS).items()}
    assert weights_fault(save(turned), ONNX) == ""


@pytest.mark.parametrize("name", ["0.weight", "1.weight", "2.weight", "0.bias", "2.bias"])
def test_one_number_that_is_another_is_found(name: str) -> None:
    arrays = load(TENSORS)
    arrays[name].flat[-1] += 1e-6
    fault = weights_fault(save(arrays), ONNX)
    expected = (
        f"its {name} is not that of the network" if "bias" in name else "it does not have the weights of the network"
    )
    assert fault == expected


def test_a_part_of_a_matrix_is_not_the_matrix() -> None:
    """Arrays are looked up among the network's tensors: searched for in its bytes, many would take for ever."""
    arrays = load(TENSORS)
    halves = {"0.weight": arrays["0.weight"][:4], "more.weight": arrays["0.weight"][4:]}
    assert weights_fault(save(arrays | halves), ONNX) == "it does not have the weights of the network"


def test_what_only_training_uses_is_free() -> None:
    arrays = load(TENSORS) | {"value.weight": np.ones((3, 3)), "value.bias": np.ones(3), "log_std": np.zeros(8)}
    assert weights_fault(save(arrays), ONNX) == ""


@pytest.mark.parametrize("name", ["mlp_extractor.policy_net.0.weight", "action_net.weight", "normaliser.mean"])
def test_what_training_begins_with_is_compared_whatever_else_is_there(name: str) -> None:
    """The network's own matrices under names that nothing reads do not make others right."""
    arrays = load(TENSORS)
    assert weights_fault(save(arrays | {"action_net.weight": arrays["2.weight"]}), ONNX) == ""
    other = np.full((8, 31), 0.5, np.float32)
    assert weights_fault(save(arrays | {name: other}), ONNX) == f"its {name} is not that of the network"


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"any text at all",
        TENSORS[:-1],
        TENSORS + b"hidden",
        TENSORS[:100],
        struct.pack("<Q", 2**63) + b"{}",
        with_header([]),
        with_header({}),
        with_header({"a": 1}),
        with_header({"a": {"dtype": "F32", "shape": [2], "data_offsets": [0, 4]}}, bytes(4)),
        with_header({"a": {"dtype": "F32", "shape": [1], "data_offsets": [4, 8]}}, bytes(8)),
        with_header({"a": {"dtype": "F32", "shape": [-1, "x"], "data_offsets": [0, 4]}}, bytes(4)),
    ],
)
def test_what_is_no_safetensors_file_is_said_to_be_none(content: bytes) -> None:
    assert weights_fault(content, ONNX) == "it is not a safetensors file"
