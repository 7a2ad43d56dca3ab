"""policy.onnx in onnxruntime, and whether a bundle's weights are those of its network.

Training continues from the weights, a flight runs the network. safetensors: 8 bytes with the length of a JSON object,
the object, the numbers (https://github.com/huggingface/safetensors#format).
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Set
from contextlib import contextmanager
from itertools import pairwise
from math import prod
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import PolicyError
from waypointctl.limits import limit_hint
from waypointctl.policy.onnx_audit import LIMIT, TooLarge, audit
from waypointctl.policy.onnx_graph import FLOAT, read_graph
from waypointctl.policy.protobuf_fields import Refused

if TYPE_CHECKING:
    from onnxruntime import InferenceSession

EXPORT_AGAIN: Final = (
    "`waypointctl train RECIPE.yaml --resume` writes the policy again from its run's newest checkpoint"
)
_OTHER: Final = "choose another policy, or train this one again"
_FATAL: Final = 4  # onnxruntime's log level; what it refuses comes as an exception


_HEAD_BYTES: Final = 8
_MOST_HEADER_BYTES: Final = 2**20
_TYPES: Final = {"F32": "<f4", "F64": "<f8"}
_WEIGHT: Final = ".weight"  # ends the name of a layer's matrix
_BIAS: Final = ".bias"
# What training begins the network with, by the names that PPO's learner gives.
_READ: Final = ("mlp_extractor.policy_net.", "action_net.", "normaliser.mean")

Arrays = dict[str, NDArray[np.float32]]


class Network:
    """An ONNX model from "observation", (n, k) float32, to "action", (n, nu) float32."""

    def __init__(self, model: bytes, where: str, threads: int = 1) -> None:
        """Read a model, and run it once on zeros.

        Args:
            model: the ONNX file's bytes.
            where: the file's name, for messages.
            threads: threads of one call; more than one is only faster for large networks and batches.

        Raises:
            PolicyError: it is not an ONNX model of that shape, has what a policy must not have, or does not run.
        """
        self._where = where
        with _refusing(where):
            self._audited = audit(model)
        self._allowed: set[int] = set()  # numbers of observations that it may run on
        self.input_size, self.output_size = self._audited.inputs, self._audited.outputs
        self._session = _session(model, where, threads)
        self._input_name: str = self._session.get_inputs()[0].name
        self._output_names: list[str] = [self._session.get_outputs()[0].name]
        self.run(np.zeros((1, self.input_size)))

    def run(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return actions (n, nu) for observations (n, k).

        Raises:
            PolicyError: onnxruntime cannot run the network, the network exceeds the limit for this many
                observations, or an action is not a finite number.
        """
        if len(observation) not in self._allowed:
            with _refusing(self._where):
                self._audited.require(len(observation))
            self._allowed.add(len(observation))
        feed = {self._input_name: observation.astype(np.float32)}
        try:
            (found,) = self._session.run(self._output_names, feed)
        except Exception as error:  # onnxruntime's exceptions have no base class of their own
            raise PolicyError(f"onnxruntime cannot run it: {_reason(error)}", where=self._where, hint=_OTHER) from error
        if found.shape != (len(observation), self.output_size) or found.dtype != np.float32:
            problem = f"the network gave {found.dtype} of shape {found.shape} for {len(observation)} observations"
            raise PolicyError(problem, where=self._where, hint=_OTHER)
        action: NDArray[np.float64] = found.astype(np.float64)
        # The squares of float32 numbers cannot overflow in float64, and this way takes less than a microsecond.
        if not math.isfinite(np.vdot(action, action)):
            problem = "the network gave a number that is not finite: the policy is damaged, or its training diverged"
            raise PolicyError(problem, where=self._where, hint=_OTHER)
        return action


@contextmanager
def _refusing(where: str) -> Iterator[None]:
    """Refuse a network that is not allowed, with the reason."""
    try:
        yield
    except Refused as error:
        problem = f"the model has {error}; a policy is one file of standard, deterministic operators (docs/limits.md)"
        raise PolicyError(problem, where=where, hint=EXPORT_AGAIN) from error
    except TooLarge as error:
        raise PolicyError(str(error), where=where, hint=limit_hint(LIMIT, error.work)) from error
    except ValueError as error:
        raise PolicyError(f"not the ONNX model of a policy: {error}", where=where, hint=EXPORT_AGAIN) from error


def _session(model: bytes, where: str, threads: int) -> InferenceSession:
    os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")  # on, it leaves a file in the folder for temporary files
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.execution_mode = onnxruntime.ExecutionMode.ORT_SEQUENTIAL
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_ALL
    options.use_deterministic_compute = True
    options.log_severity_level = _FATAL
    try:
        return onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
    except Exception as error:
        raise PolicyError(f"onnxruntime cannot read it: {_reason(error)}", where=where, hint=EXPORT_AGAIN) from error


def _reason(error: Exception) -> str:
    return next(iter(str(error).strip().splitlines()), type(error).__name__)


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
