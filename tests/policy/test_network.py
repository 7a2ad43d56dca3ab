from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import onnx
import pytest

from waypointctl.errors import PolicyError
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.network import Network


@pytest.fixture
def sound(tmp_path: Path, make_policy: Callable[..., LoadedPolicy]) -> onnx.ModelProto:
    return onnx.load_from_string(make_policy(tmp_path / "tiny").files["policy.onnx"])


def refusal(model: bytes) -> str:
    with pytest.raises(PolicyError) as caught:
        Network(model, "policy.onnx")
    return str(caught.value)


def test_it_knows_its_sizes(sound: onnx.ModelProto) -> None:
    network = Network(sound.SerializeToString(), "policy.onnx")
    assert (network.input_size, network.output_size) == (31, 8)


def test_a_network_for_one_batch_size_only_is_refused(sound: onnx.ModelProto) -> None:
    sound.graph.input[0].type.tensor_type.shape.dim[0].dim_value = 4
    assert "the input 'observation' is a tensor(float) of shape [4, 31]; a policy's is (n, size)" in refusal(
        sound.SerializeToString()
    )


def test_a_network_of_float64_is_refused(sound: onnx.ModelProto) -> None:
    sound.graph.input[0].type.tensor_type.elem_type = onnx.TensorProto.DOUBLE
    to_float = onnx.helper.make_node("Cast", ["observation"], ["single"], to=onnx.TensorProto.FLOAT)
    sound.graph.node[0].input[0] = "single"
    sound.graph.node.insert(0, to_float)
    assert "the input 'observation' is a tensor(double) of shape ['n', 31]; a policy's is" in refusal(
        sound.SerializeToString()
    )


def test_a_network_with_a_second_input_is_refused(sound: onnx.ModelProto) -> None:
    sound.graph.input.append(onnx.helper.make_tensor_value_info("state", onnx.TensorProto.FLOAT, ["n", 4]))
    assert "2 inputs and 1 outputs; a policy has one of each" in refusal(sound.SerializeToString())


def test_weights_in_another_file_are_refused(sound: onnx.ModelProto) -> None:
    weight = next(tensor for tensor in sound.graph.initializer if tensor.name == "layer0.weight")
    onnx.external_data_helper.set_external_data(weight, "elsewhere.bin")
    weight.ClearField("raw_data")
    assert "policy.onnx: the model has a tensor kept in another file" in refusal(sound.SerializeToString())


def test_operators_of_a_foreign_domain_are_refused(sound: onnx.ModelProto) -> None:
    sound.graph.node[0].domain = "com.example"
    sound.opset_import.append(onnx.helper.make_opsetid("com.example", 1))
    assert "the model has operators of the domain 'com.example'; a policy is one file of standard, det" in refusal(
        sound.SerializeToString()
    )


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (b"no model", "not the ONNX model of a policy: "),
        (b"", "not the ONNX model"),
        (b"\x08\x07", "not the ONNX model"),
    ],
)
def test_what_is_no_onnx_model_is_refused(model: bytes, message: str) -> None:
    assert refusal(model).startswith(f"policy.onnx: {message}")


def test_what_onnxruntime_refuses_is_told_once(sound: onnx.ModelProto, capfd: pytest.CaptureFixture[str]) -> None:
    sound.graph.node[0].attribute.append(onnx.helper.make_attribute("colour", 3))
    assert "policy.onnx: onnxruntime cannot read it: " in refusal(sound.SerializeToString())
    assert capfd.readouterr().err == ""


def test_what_fails_when_it_runs_is_told_once(sound: onnx.ModelProto, capfd: pytest.CaptureFixture[str]) -> None:
    """An index that depends on the observation is only looked at then: on zeros, or later."""
    graph = sound.graph
    graph.node[-1].output[0] = "computed"
    graph.initializer.extend(
        [
            onnx.numpy_helper.from_array(np.array(7, np.int64), "seven"),
            onnx.numpy_helper.from_array(np.array([0], np.int64), "first"),
            onnx.numpy_helper.from_array(np.zeros((8, 1), np.float32), "rows"),
        ]
    )
    for node in (
        onnx.helper.make_node("Gather", ["observation", "first"], ["column"], axis=1),
        onnx.helper.make_node("Cast", ["column"], ["index"], to=onnx.TensorProto.INT64),
        onnx.helper.make_node("Add", ["index", "seven"], ["late"]),
        onnx.helper.make_node("Gather", ["rows", "late"], ["row"]),
        onnx.helper.make_node("ReduceSum", ["row", "first"], ["sum"], keepdims=0),
    ):
        graph.node.append(node)
    graph.node[-1].input[1] = ""
    graph.node.append(onnx.helper.make_node("Add", ["computed", "sum"], ["action"]))
    network = Network(sound.SerializeToString(), "policy.onnx")
    observation = np.zeros((1, 31))
    assert network.run(observation).shape == (1, 8)
    observation[0, 0] = 1.0
    with pytest.raises(PolicyError, match=r"^policy\.onnx: onnxruntime cannot run it: .*indices"):
        network.run(observation)
    graph.initializer[-3].CopyFrom(onnx.numpy_helper.from_array(np.array(8, np.int64), "seven"))
    assert refusal(sound.SerializeToString()).startswith("policy.onnx: onnxruntime cannot run it: ")
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_an_action_that_is_not_finite_is_refused(sound: onnx.ModelProto, value: float) -> None:
    bias = next(tensor for tensor in sound.graph.initializer if tensor.name == "layer2.bias")
    numbers = onnx.numpy_helper.to_array(bias).copy()
    numbers[3] = value
    bias.CopyFrom(onnx.numpy_helper.from_array(numbers, bias.name))
    assert refusal(sound.SerializeToString()).startswith("policy.onnx: the network gave a number that is not finite")


def test_an_observation_that_is_not_finite_gives_no_action(sound: onnx.ModelProto) -> None:
    network = Network(sound.SerializeToString(), "policy.onnx")
    with pytest.raises(PolicyError, match=r"policy\.onnx: the network gave a number that is not finite"):
        network.run(np.full((3, 31), np.nan))


def test_the_largest_action_there_is_is_finite(sound: onnx.ModelProto) -> None:
    bias = next(tensor for tensor in sound.graph.initializer if tensor.name == "layer2.bias")
    largest = np.full(8, np.finfo(np.float32).max, np.float32)
    bias.CopyFrom(onnx.numpy_helper.from_array(largest, bias.name))
    action = Network(sound.SerializeToString(), "policy.onnx").run(np.zeros((2, 31)))
    np.testing.assert_allclose(action, float(largest[0]), rtol=1e-6)
