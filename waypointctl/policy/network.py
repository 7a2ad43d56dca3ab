"""policy.onnx in onnxruntime."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import PolicyError
from waypointctl.policy.onnx_audit import unsafe_parts

if TYPE_CHECKING:
    from onnxruntime import InferenceSession

EXPORT_AGAIN: Final = (
    "`waypointctl train RECIPE.yaml --resume` writes the policy again from its run's newest checkpoint"
)
_FATAL: Final = 4  # onnxruntime's log level; what it refuses comes as an exception


class Network:
    """An ONNX model from "observation", (n, k) float32, to "action", (n, nu) float32."""

    def __init__(self, model: bytes, where: str, threads: int = 1) -> None:
        """Read a model.

        Args:
            model: the ONNX file's bytes.
            where: the file's name, for messages.
            threads: how many share one call; more than one only pays for large networks and batches.

        Raises:
            PolicyError: it is not an ONNX model of that shape, or it needs more than the file itself.
        """
        _refuse_unsafe(model, where)
        self._where = where
        self._session = _session(model, where, threads)
        inputs, outputs = self._session.get_inputs(), self._session.get_outputs()
        if len(inputs) != 1 or len(outputs) != 1:
            problem = f"{len(inputs)} inputs and {len(outputs)} outputs; a policy has one of each"
            raise PolicyError(problem, where=where, mend=EXPORT_AGAIN)
        self.input_size = _width(inputs[0], "input", where)
        self.output_size = _width(outputs[0], "output", where)
        self._input_name: str = inputs[0].name
        self._output_names: list[str] = [outputs[0].name]

    def run(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return actions (n, nu) for observations (n, k).

        Raises:
            PolicyError: an action is not a finite number.
        """
        feed = {self._input_name: observation.astype(np.float32)}
        action = cast(NDArray[np.float64], self._session.run(self._output_names, feed)[0].astype(np.float64))
        # The squares of float32 numbers cannot overflow in float64, and this way takes less than a microsecond.
        if not math.isfinite(np.vdot(action, action)):
            problem = "the network gave a number that is not finite: the policy is damaged, or its training diverged"
            raise PolicyError(problem, where=self._where, mend="choose another policy, or train this one again")
        return action


def _refuse_unsafe(model: bytes, where: str) -> None:
    try:
        unsafe = unsafe_parts(model)
    except ValueError as error:
        raise PolicyError(f"not an ONNX model: {error}", where=where, mend=EXPORT_AGAIN) from error
    if unsafe:
        problem = f"the model has {' and '.join(unsafe)}; a policy is one file of standard ONNX operators"
        raise PolicyError(problem, where=where, mend=EXPORT_AGAIN)


def _session(model: bytes, where: str, threads: int) -> InferenceSession:
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
    except Exception as error:  # onnxruntime's exceptions have no base class of their own
        reason = str(error).strip().splitlines()[0]
        raise PolicyError(f"onnxruntime cannot read it: {reason}", where=where, mend=EXPORT_AGAIN) from error


def _width(port: Any, what: str, where: str) -> int:
    match port.type, port.shape:
        case "tensor(float)", [str() | None, int(width)]:
            return width
    problem = f"the {what} {port.name!r} is a {port.type} of shape {port.shape}; a policy's is (n, size) of float32"
    raise PolicyError(problem, where=where, mend=EXPORT_AGAIN)
