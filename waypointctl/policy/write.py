"""Writing a policy bundle, and its network as ONNX: a normaliser and a multilayer perceptron, the same bytes always."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import OutputError
from waypointctl.policy.bundle import LoadedPolicy, load_policy_bytes
from waypointctl.policy.manifest import MANIFEST, NETWORK, WEIGHTS, Manifest, PolicyDescription

if TYPE_CHECKING:
    from onnx import NodeProto, TensorProto

Activation: TypeAlias = Literal["elu", "tanh", "relu"]
Layer: TypeAlias = tuple[NDArray[np.floating], NDArray[np.floating]]

OPERATORS: Final[dict[Activation, str]] = {"elu": "Elu", "tanh": "Tanh", "relu": "Relu"}
OPSET: Final = 17  # read by every onnxruntime since 1.12; the operators used here are older
IR_VERSION: Final = 8  # goes with the opset, whatever the installed onnx would write
_LAST: Final = MANIFEST  # until it is replaced, the new files fail its hashes


def bundle_files(description: PolicyDescription, onnx: bytes, safetensors: bytes) -> dict[str, bytes]:
    """Return the files of a bundle by name, for `load_policy_bytes` or a folder."""
    contents = {NETWORK: onnx, WEIGHTS: safetensors}
    manifest = Manifest.model_validate(
        {
            **{field: getattr(description, field) for field in PolicyDescription.model_fields},
            "files": {name: _record(content) for name, content in contents.items()},
        }
    )
    return contents | {MANIFEST: f"{manifest.model_dump_json(indent=2)}\n".encode()}


def write_bundle(folder: Path, description: PolicyDescription, onnx: bytes, safetensors: bytes) -> LoadedPolicy:
    """Write a bundle and return it, loaded.

    The files are written into a hidden folder and moved into place when they are complete. A folder that does not
    exist appears whole. In one that does, files of other names stay, and the bundle's are replaced one by one,
    manifest.json last: a reader gets the old bundle, the new one, or a refusal because of the hashes.

    Args:
        folder: where the bundle goes.
        description: all of the manifest but the files.
        onnx: the normaliser and the network, from observation (n, k) to action (n, nu), float32.
        safetensors: the weights and the normaliser's statistics, for going on with training.

    Raises:
        PolicyError: the network does not fit the description; nothing is written.
        OutputError: the folder cannot be written.
    """
    policy = load_policy_bytes(bundle_files(description, onnx, safetensors), str(folder))
    copy_bundle(policy, folder)
    return policy


def copy_bundle(policy: LoadedPolicy, folder: Path) -> None:
    """Write a policy's files into `folder`, in the way and with the errors of `write_bundle`."""
    # In a folder that is there, which can be another file system than the one around it, such as a container's volume.
    parent = folder if folder.is_dir() else folder.parent
    staging = parent / f".{folder.name}.{os.getpid()}.tmp"
    try:
        staging.mkdir(parents=True)
        _put(folder, staging, policy.files)
    except OSError as error:
        problem = f"the policy cannot be written: {error.strerror}"
        raise OutputError(problem, where=str(folder), hint="use a folder that you can write to") from error
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _record(content: bytes) -> dict[str, str | int]:
    return {"sha256": hashlib.sha256(content).hexdigest(), "size": len(content)}


def _put(folder: Path, staging: Path, files: Mapping[str, bytes]) -> None:
    for name, content in files.items():
        (staging / name).write_bytes(content)
    if not folder.exists():
        staging.rename(folder)
        return
    for name in sorted(files, key=lambda name: name == _LAST):
        (staging / name).replace(folder / name)


def mlp_to_onnx(
    layers: Sequence[Layer],
    activation: Activation,
    mean: NDArray[np.floating],
    variance: NDArray[np.floating],
    *,
    clip: float,
    epsilon: float,
    squash: bool = False,
) -> bytes:
    """Return the ONNX model of `clip((x - mean) / sqrt(variance + epsilon))` followed by an MLP.

    The normaliser is stable-baselines3's VecNormalize. The model maps "observation", (n, k) float32, to
    "action", (n, nu) float32, not clipped. Nothing but the arguments goes into the bytes.

    Args:
        layers: weight (out, in) and bias (out,) of each linear layer, as torch keeps them; all but the last
            are followed by the activation.
        activation: elu (alpha 1), tanh or relu.
        mean: (k,) of the observations.
        variance: (k,) of the observations.
        clip: bound of the normalised observation, > 0.
        epsilon: added to the variance, > 0.
        squash: end with tanh, as SAC and TD3 do, instead of the last linear layer.

    Raises:
        ValueError: the shapes do not fit each other, or a number is not finite.
    """
    from onnx import TensorProto, checker, helper

    _refuse_bad_numbers(layers, mean, variance, clip, epsilon)
    nodes, tensors = _normaliser(mean, variance, clip, epsilon)
    last = len(layers) - 1
    for i, layer in enumerate(layers):
        node, weights = _linear(i, layer, output="action" if i == last and not squash else f"layer{i}.out")
        nodes.append(node)
        tensors.extend(weights)
        if i < last:
            nodes.append(helper.make_node(OPERATORS[activation], [node.output[0]], [f"{node.name}.active"]))
    if squash:
        nodes.append(helper.make_node("Tanh", [nodes[-1].output[0]], ["action"]))
    graph = helper.make_graph(
        nodes,
        "policy",
        [helper.make_tensor_value_info("observation", TensorProto.FLOAT, ["n", mean.size])],
        [helper.make_tensor_value_info("action", TensorProto.FLOAT, ["n", layers[-1][1].size])],
        tensors,
    )
    model = helper.make_model(
        graph, producer_name="waypointctl", ir_version=IR_VERSION, opset_imports=[helper.make_opsetid("", OPSET)]
    )
    checker.check_model(model, full_check=True)
    return model.SerializeToString(deterministic=True)


def _normaliser(
    mean: NDArray[np.floating], variance: NDArray[np.floating], clip: float, epsilon: float
) -> tuple[list[NodeProto], list[TensorProto]]:
    from onnx import helper, numpy_helper

    deviation = np.sqrt(variance.astype(np.float64) + epsilon)  # in float64, as VecNormalize has it
    constants = {"mean": mean, "deviation": deviation, "low": np.array(-clip), "high": np.array(clip)}
    nodes = [
        helper.make_node("Sub", ["observation", "mean"], ["centred"]),
        helper.make_node("Div", ["centred", "deviation"], ["scaled"]),
        helper.make_node("Clip", ["scaled", "low", "high"], ["layer0.in"]),
    ]
    return nodes, [numpy_helper.from_array(value.astype(np.float32), name) for name, value in constants.items()]


def _linear(index: int, layer: Layer, *, output: str) -> tuple[NodeProto, list[TensorProto]]:
    from onnx import helper, numpy_helper

    name = f"layer{index}"
    source = "layer0.in" if index == 0 else f"layer{index - 1}.active"
    node = helper.make_node("Gemm", [source, f"{name}.weight", f"{name}.bias"], [output], name=name, transB=1)
    weights = zip((f"{name}.weight", f"{name}.bias"), layer, strict=True)
    return node, [numpy_helper.from_array(np.ascontiguousarray(w, dtype=np.float32), n) for n, w in weights]


def _refuse_bad_numbers(
    layers: Sequence[Layer], mean: NDArray[np.floating], variance: NDArray[np.floating], clip: float, epsilon: float
) -> None:
    if not layers:
        raise ValueError("a network needs at least one layer")
    if mean.ndim != 1 or variance.shape != mean.shape:
        raise ValueError(f"mean {mean.shape} and variance {variance.shape} must be of one shape (k,)")
    size = mean.size
    for i, (weight, bias) in enumerate(layers):
        if weight.ndim != 2 or weight.shape[1] != size or bias.shape != weight.shape[:1]:
            raise ValueError(f"layer {i}: weight {weight.shape} and bias {bias.shape} must be (out, {size}) and (out,)")
        size = weight.shape[0]
    arrays = [mean, variance, *(array for layer in layers for array in layer)]
    if not all(np.isfinite(array).all() for array in arrays):
        raise ValueError("weights and statistics must be finite")
    if not (variance >= 0).all() or not clip > 0 or not epsilon > 0:
        raise ValueError("variance must be >= 0, clip and epsilon > 0")
