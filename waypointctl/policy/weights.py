"""Whether a bundle's weights are those of its network: training continues from the weights, a flight runs the network.

safetensors: 8 bytes with the length of a JSON object, the object, the numbers
(https://github.com/huggingface/safetensors#format).
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Set
from itertools import pairwise
from math import prod
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.policy.onnx_graph import FLOAT, read_graph

_HEAD_BYTES: Final = 8
_MOST_HEADER_BYTES: Final = 2**20
_TYPES: Final = {"F32": "<f4", "F64": "<f8"}
_WEIGHT: Final = ".weight"  # ends the name of a layer's matrix
_BIAS: Final = ".bias"
# What training begins the network with, by the names that `waypointctl.training.export.weights` gives.
_READ: Final = ("mlp_extractor.policy_net.", "action_net.", "normaliser.mean")

Arrays = dict[str, NDArray[np.float32]]


def weights_fault(safetensors: bytes, network: bytes) -> str:
    """Return why the weights are not those of the network, in words; empty if they are.

    Every matrix of the network has to be among them, and the bias that belongs to each; and what training begins the
    network with has to be in it. What training alone uses, such as a value function, is in no network and is not
    compared.
    """
    try:
        arrays = _floats(safetensors)
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return "it is not a safetensors file"
    constants = [constant for constant in read_graph(network).constants if constant.type == FLOAT]
    contents = {bytes(constant.content) for constant in constants}
    used = {name for name, array in arrays.items() if array.ndim >= 2 and _is_in(array, contents)}
    needed = sum(prod(constant.shape) for constant in constants if len(constant.shape) >= 2)
    if sum(arrays[name].size for name in used) < needed:
        return "it does not have the weights of the network"
    biases = (f"{name.removesuffix(_WEIGHT)}{_BIAS}" for name in used if name.endswith(_WEIGHT))
    compared = {*biases, *(name for name in arrays if name.startswith(_READ))}
    other = next((name for name in sorted(compared) if name in arrays and not _is_in(arrays[name], contents)), None)
    return "" if other is None else f"its {other} is not that of the network"


def _is_in(array: NDArray[np.float32], contents: Set[bytes]) -> bool:
    return any(it.tobytes() in contents for it in (array, np.ascontiguousarray(array.T)))


def _floats(content: bytes) -> Arrays:
    """Return the arrays of 4 and 8 bytes a number, as float32.

    Raises:
        ValueError, LookupError, TypeError, AttributeError, RecursionError: it is not such a file.
    """
    size = int.from_bytes(content[:_HEAD_BYTES], "little")
    begin = _HEAD_BYTES + size
    if len(content) < begin or size > _MOST_HEADER_BYTES:
        raise ValueError("no header")
    header = json.loads(content[_HEAD_BYTES:begin])
    header.pop("__metadata__", None)
    spans = sorted(described["data_offsets"] for described in header.values())
    # The arrays neither overlap nor leave gaps.
    if [0, len(content) - begin] != [spans[0][0], spans[-1][1]] or any(a[1] != b[0] for a, b in pairwise(spans)):
        raise ValueError("the arrays are not all of the file")
    return dict(_read(header, memoryview(content)[begin:]))


def _read(header: dict[str, dict[str, Any]], data: memoryview) -> Iterator[tuple[str, NDArray[np.float32]]]:
    for name, described in header.items():
        if described["dtype"] in _TYPES:
            first, last = described["data_offsets"]
            array = np.frombuffer(data[first:last], _TYPES[described["dtype"]]).reshape(described["shape"])
            with np.errstate(over="ignore"):
                yield name, array.astype(np.float32)
