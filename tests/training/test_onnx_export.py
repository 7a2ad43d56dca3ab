from __future__ import annotations

import hashlib
import re
import subprocess
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
import torch
from numpy.typing import NDArray
from safetensors.numpy import load

from waypointctl.policy.bundle import load_policy
from waypointctl.policy.network import Network
from waypointctl.policy.write import Activation, Layer, mlp_to_onnx

SIZES = (31, 16, 12, 8)
BUNDLES = sorted(path.parent for path in (Path(__file__).parents[2] / "policies").glob("*/manifest.json"))


def layers_of(seed: int) -> list[Layer]:
    rng = np.random.default_rng(seed)
    pairs = pairwise(SIZES)
    return [(rng.normal(size=(out, into)) / np.sqrt(into), rng.normal(size=out)) for into, out in pairs]


def statistics(seed: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed + 100)
    return {"mean": rng.normal(size=31), "variance": rng.uniform(0.01, 4.0, 31), "clip": 3.0, "epsilon": 1e-2}


def observations(n: int) -> NDArray[np.float64]:
    return np.random.default_rng(7).normal(scale=4.0, size=(n, 31))  # wide enough for the clip to matter


def numpy_oracle(x: NDArray[np.float64], layers: list[Layer], activation: Activation) -> NDArray[np.float64]:
    functions: dict[str, Callable[[NDArray[np.float64]], NDArray[np.float64]]] = {
        "elu": lambda h: np.where(h > 0, h, np.exp(np.minimum(h, 0)) - 1),
        "tanh": np.tanh,
        "relu": lambda h: np.maximum(h, 0),
    }
    s = statistics(0)
    h = np.clip((x - s["mean"]) / np.sqrt(s["variance"] + s["epsilon"]), -s["clip"], s["clip"])
    for weight, bias in layers[:-1]:
        h = functions[activation](h @ weight.T + bias)
    weight, bias = layers[-1]
    return np.asarray(h @ weight.T + bias)


@pytest.mark.parametrize("activation", ["elu", "tanh", "relu"])
@pytest.mark.parametrize("n", [1, 33])
def test_it_computes_what_numpy_computes(activation: Activation, n: int) -> None:
    network = Network(mlp_to_onnx(layers_of(0), activation, **statistics(0)), "model")
    x = observations(n)
    np.testing.assert_allclose(network.run(x), numpy_oracle(x, layers_of(0), activation), atol=2e-5)


PAPER = (29, 128, 128, 128, 128, 128, 128, 8)  # the paper's network
FUNCTIONS: dict[str, Any] = {"elu": torch.nn.ELU, "tanh": torch.nn.Tanh, "relu": torch.nn.ReLU}


@pytest.mark.parametrize("squash", [False, True])
@pytest.mark.parametrize("sizes", [SIZES, PAPER, (31, 8)])
@pytest.mark.parametrize("activation", ["elu", "tanh", "relu"])
def test_it_computes_what_torch_computes(activation: Activation, sizes: tuple[int, ...], squash: bool) -> None:
    torch.manual_seed(2)
    modules: list[torch.nn.Module] = []
    for into, out in pairwise(sizes):
        modules += [torch.nn.Linear(into, out), FUNCTIONS[activation]()]
    model = torch.nn.Sequential(*modules[:-1], *([torch.nn.Tanh()] if squash else []))
    with torch.no_grad():
        for parameter in model.parameters():
            parameter.mul_(2.0)  # as torch draws them, six layers make next to nothing of their input
    layers = [(m.weight.detach().numpy(), m.bias.detach().numpy()) for m in modules if isinstance(m, torch.nn.Linear)]
    model_bytes = mlp_to_onnx(
        layers, activation, np.zeros(sizes[0]), np.ones(sizes[0]), clip=1e6, epsilon=1e-12, squash=squash
    )
    x = np.random.default_rng(7).normal(scale=2.0, size=(50, sizes[0]))
    with torch.no_grad():
        expected = model(torch.tensor(x, dtype=torch.float32)).numpy()
    assert np.ptp(expected, axis=0).min() > 0.1
    np.testing.assert_allclose(Network(model_bytes, "model").run(x), expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("folder", BUNDLES, ids=lambda folder: folder.name)
def test_the_shipped_networks_give_the_actions_of_their_weights_in_torch(folder: Path) -> None:
    policy = load_policy(folder)
    weights = load(policy.files["weights.safetensors"])
    modules: list[torch.nn.Module] = []
    hidden = [name for name in weights if re.fullmatch(r"mlp_extractor\.policy_net\.\d+\.weight", name)]
    for name in sorted(hidden, key=lambda name: int(name.split(".")[2])):
        modules += [linear(weights, name.removesuffix(".weight")), FUNCTIONS[policy.manifest.network.activation]()]
    model = torch.nn.Sequential(*modules, linear(weights, "action_net"))
    assert [m.out_features for m in modules[::2] if isinstance(m, torch.nn.Linear)] == [
        *policy.manifest.network.hidden_sizes
    ]
    mean, variance = weights["normaliser.mean"], weights["normaliser.var"]
    noise = 2.0 * np.random.default_rng(8).normal(size=(200, mean.size))
    # What never varied in training, as a single point's goal, is one off: float32 tells no smaller part of its range.
    x = mean + np.where(variance < 1e-6, np.sign(noise), np.sqrt(variance) * noise)
    normalised = np.clip((x - mean) / np.sqrt(variance + 1e-8), -10.0, 10.0)
    with torch.no_grad():
        expected = model(torch.tensor(normalised, dtype=torch.float32)).numpy()
    np.testing.assert_allclose(policy.act(x), expected, rtol=1e-4, atol=1e-4)


def linear(weights: dict[str, NDArray[np.float32]], name: str) -> torch.nn.Linear:
    weight, bias = torch.tensor(weights[f"{name}.weight"]), torch.tensor(weights[f"{name}.bias"])
    made = torch.nn.Linear(weight.shape[1], weight.shape[0])
    made.load_state_dict({"weight": weight, "bias": bias})
    return made


def test_it_normalises_as_vecnormalize_does() -> None:
    gymnasium = pytest.importorskip("gymnasium")
    from stable_baselines3.common.running_mean_std import RunningMeanStd
    from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

    env = VecNormalize(DummyVecEnv([lambda: gymnasium.make("Pendulum-v1")]), clip_obs=1.5, epsilon=1e-3)
    rms = env.obs_rms
    assert isinstance(rms, RunningMeanStd)
    rms.update(np.random.default_rng(0).normal(loc=1.0, scale=3.0, size=(100, 3)))
    identity: list[Layer] = [(np.eye(3), np.zeros(3))]
    model = mlp_to_onnx(identity, "elu", rms.mean, rms.var, clip=1.5, epsilon=1e-3)
    x = np.random.default_rng(1).normal(scale=5.0, size=(50, 3))
    np.testing.assert_allclose(Network(model, "model").run(x), np.asarray(env.normalize_obs(x)), atol=1e-6)


def test_actions_are_not_clipped() -> None:
    layer: list[Layer] = [(np.zeros((2, 3)), np.array([5.0, -7.0]))]
    model = mlp_to_onnx(layer, "tanh", np.zeros(3), np.ones(3), clip=1.0, epsilon=1e-8)
    np.testing.assert_array_equal(Network(model, "model").run(np.ones((1, 3))), [[5.0, -7.0]])


def test_the_same_weights_give_the_same_bytes_in_another_process() -> None:
    code = (
        "import hashlib, numpy as np\n"
        "from waypointctl.policy.write import mlp_to_onnx\n"
        "w = [(np.full((4, 3), 0.5), np.zeros(4)), (np.full((2, 4), -0.25), np.ones(2))]\n"
        "b = mlp_to_onnx(w, 'elu', np.zeros(3), np.ones(3), clip=10.0, epsilon=1e-8)\n"
        "print(hashlib.sha256(b).hexdigest())\n"
    )
    outputs = {subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout for _ in range(2)}
    weights: list[Layer] = [(np.full((4, 3), 0.5), np.zeros(4)), (np.full((2, 4), -0.25), np.ones(2))]
    here = mlp_to_onnx(weights, "elu", np.zeros(3), np.ones(3), clip=10.0, epsilon=1e-8)
    assert outputs == {f"{hashlib.sha256(here).hexdigest()}\n".encode()}


def test_the_model_names_its_ports_and_uses_standard_operators_only() -> None:
    model = onnx.load_from_string(mlp_to_onnx(layers_of(0), "elu", **statistics(0)))
    assert [port.name for port in model.graph.input] == ["observation"]
    assert [port.name for port in model.graph.output] == ["action"]
    operators = [node.op_type for node in model.graph.node]
    assert operators == ["Sub", "Div", "Clip", "Gemm", "Elu", "Gemm", "Elu", "Gemm"]
    assert {opset.domain for opset in model.opset_import} == {""}


@pytest.mark.parametrize(
    ("layers", "changes", "message"),
    [
        ([], {}, "at least one layer"),
        ([(np.ones((2, 5)), np.ones(2))], {}, r"layer 0: weight \(2, 5\) and bias \(2,\)"),
        ([(np.ones((2, 3)), np.ones(3))], {}, r"must be \(out, 3\) and \(out,\)"),
        ([(np.full((2, 3), np.nan), np.ones(2))], {}, "finite"),
        ([(np.ones((2, 3)), np.ones(2))], {"mean": np.zeros(4)}, "one shape"),
        ([(np.ones((2, 3)), np.ones(2))], {"variance": -np.ones(3)}, "variance must be >= 0"),
        ([(np.ones((2, 3)), np.ones(2))], {"clip": 0.0}, "clip and epsilon > 0"),
    ],
)
def test_what_does_not_fit_is_refused(layers: list[Layer], changes: dict[str, Any], message: str) -> None:
    arguments: dict[str, Any] = {"mean": np.zeros(3), "variance": np.ones(3), "clip": 1.0, "epsilon": 1e-8} | changes
    with pytest.raises(ValueError, match=message):
        mlp_to_onnx(layers, "elu", **arguments)
