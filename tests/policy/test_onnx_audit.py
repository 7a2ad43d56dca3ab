"""Models that a policy must not be, refused before onnxruntime sees them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from onnx import AttributeProto, GraphProto, ModelProto, NodeProto, SparseTensorProto, TensorProto, helper

from tests.policy.hostile_networks import HOSTILE, INNER, LAST, model_of, network, node, sized
from waypointctl.errors import PolicyError
from waypointctl.limits import VARIABLE, set_limits
from waypointctl.policy.network import Network
from waypointctl.policy.onnx_audit import ROWS, TooLarge, audit
from waypointctl.policy.onnx_graph import read_graph
from waypointctl.policy.protobuf_fields import Refused

ELSEWHERE = "a tensor kept in another file"
FOREIGN = "operators of the domain 'com.example'"


def outside() -> TensorProto:
    tensor = TensorProto(name="weight", data_type=TensorProto.FLOAT, dims=[2])
    tensor.data_location = TensorProto.EXTERNAL
    tensor.external_data.add(key="location", value="/etc/passwd")
    return tensor


def foreign(name: str = "Call") -> NodeProto:
    return helper.make_node(name, ["x"], ["y"], domain="com.example")


def holding(attribute: AttributeProto) -> ModelProto:
    return model_of(GraphProto(node=[NodeProto(op_type="If", attribute=[attribute])]))


def with_function() -> ModelProto:
    model = model_of(GraphProto())
    model.functions.append(helper.make_function("", "f", ["x"], ["y"], [foreign()], []))
    return model


def with_training() -> ModelProto:
    model = model_of(GraphProto())
    model.training_info.add().algorithm.node.append(foreign())
    return model


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda: model_of(GraphProto(initializer=[outside()])), ELSEWHERE),
        (lambda: model_of(GraphProto(sparse_initializer=[SparseTensorProto(values=outside())])), "a sparse tensor"),
        (lambda: holding(AttributeProto(name="value", t=outside())), ELSEWHERE),
        (lambda: holding(AttributeProto(name="values", tensors=[outside()])), "an attribute of a kind"),
        (lambda: holding(AttributeProto(name="then_branch", g=GraphProto(initializer=[outside()]))), INNER),
        (lambda: model_of(GraphProto(node=[foreign()])), FOREIGN),
        (lambda: holding(AttributeProto(name="branches", graphs=[GraphProto(node=[foreign()])])), INNER),
        (with_function, "functions or training steps of its own"),
        (with_training, "functions or training steps of its own"),
        (lambda: ModelProto(opset_import=[helper.make_opsetid("com.example", 1)]), FOREIGN),
        (
            lambda: model_of(GraphProto(initializer=[TensorProto(name="w", data_type=1, dims=[2**20, 2**20])])),
            r"a tensor of shape \[1048576, 1048576\] without its numbers",
        ),
        (
            lambda: model_of(GraphProto(initializer=[TensorProto(name="w", data_type=1, dims=[2], raw_data=b"1234")])),
            r"a tensor of shape \[2\] without its numbers",
        ),
        (
            lambda: model_of(GraphProto(initializer=[TensorProto(name="w", data_type=8)])),
            "a tensor of numbers that are",
        ),
    ],
)
def test_what_a_policy_must_not_have_is_found_wherever_onnx_can_hold_it(
    make: Callable[[], ModelProto], expected: str
) -> None:
    with pytest.raises(Refused, match=expected):
        read_graph(make().SerializeToString())


@pytest.mark.parametrize("name", HOSTILE)
def test_a_model_that_draws_repeats_or_grows_without_bound_is_refused(name: str) -> None:
    model, message = HOSTILE[name]
    with pytest.raises(PolicyError, match=message):
        Network(model, "policy.onnx")


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (network(node("MatMul", "w x", "y")), "the operator MatMul does not fit what it takes"),
        (network(node("Gemm", "x", "y")), "the operator Gemm does not fit what it takes: input 1 is missing"),
        (network(node("Relu", "z", "y")), "Relu takes 'z', which no operator before it produces"),
        (network(node("Relu", "y", "r"), LAST), "Relu takes 'y', which no operator before it produces"),
        (network(), "the output for 256 observations is nothing"),
        (
            network(node("Relu", "x", "y")),
            rf"the output for 256 observations is shape \({ROWS}, 31\), not \({ROWS}, 8\)",
        ),
        (network(node("Transpose", "x", "t"), node("MatMul", "t w", "y")), "does not fit"),
    ],
)
def test_a_model_that_does_not_fit_together_is_refused(model: bytes, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        audit(model)


def test_a_network_that_takes_very_long_is_refused_unless_the_limit_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "")
    side = 2048
    wide = [node("MatMul", "x a", "h0"), *[node("MatMul", f"h{n} b", f"h{n + 1}") for n in range(9)]]
    arrays = {"a": np.zeros((31, side), np.float32), "b": np.zeros((side, side), np.float32)}
    model = network(*wide, node("MatMul", "h9 c", "y"), c=np.zeros((side, 8), np.float32), **arrays)
    with pytest.raises(
        TooLarge, match=r"has [\d,]{13,} multiplications for 256 observations; the limit policy-work is 8,589,934,592"
    ):
        audit(model)
    set_limits(["policy-work=20000000000"])
    assert audit(model).outputs == 8


def test_a_recurrent_network_as_torch_exports_it_is_read() -> None:
    """Its first state is as long as the batch, which is computed from the observation's shape."""
    rng = np.random.default_rng(0)
    model = network(
        node("Unsqueeze", "x one", "steps"),
        node("Transpose", "steps", "sequence", perm=[1, 0, 2]),
        node("Shape", "sequence", "sides"),
        node("Gather", "sides index", "count", axis=0),
        node("Unsqueeze", "count zero", "many"),
        node("Concat", "one many size", "target", axis=0),
        node("ConstantOfShape", "target", "state"),
        helper.make_node("LSTM", ["sequence", "i", "r", "", "", "state", "state"], ["all"], hidden_size=8),
        node("Squeeze", "all zero_one", "y"),
        one=sized(1),
        zero=sized(0),
        zero_one=sized(0, 1),
        index=np.array(1),
        size=sized(8),
        i=rng.normal(size=(1, 32, 31)).astype(np.float32),
        r=rng.normal(size=(1, 32, 8)).astype(np.float32),
    )
    assert audit(model).inputs == 31


def test_a_truncated_model_is_refused() -> None:
    whole = network(LAST)
    with pytest.raises(ValueError, match=r"after its message|no whole number"):
        audit(whole[: len(whole) // 2])


@given(st.binary(max_size=200))
def test_any_bytes_are_walked_or_refused(content: bytes) -> None:
    with pytest.raises(ValueError):  # noqa: PT011 - what is wrong depends on the bytes
        audit(content)


@given(st.data())
def test_any_damage_is_found_or_leaves_a_network_of_bounded_shapes(data: st.DataObject) -> None:
    model = bytearray(network(LAST))
    for _ in range(data.draw(st.integers(1, 4))):
        model[data.draw(st.integers(0, len(model) - 1))] = data.draw(st.integers(0, 255))
    try:
        audit(bytes(model))
    except ValueError:
        return


def field(tag: int, content: bytes) -> bytes:
    """Encode a length-delimited field by hand: protobuf's own encoder would not nest this deep."""
    size, varint = len(content), bytearray()
    while size > 0x7F:
        varint.append(size & 0x7F | 0x80)
        size >>= 7
    return bytes((tag, *varint, size)) + content


def test_a_model_nested_beyond_any_reason_does_not_exhaust_the_stack() -> None:
    inner = field(7 << 3 | 2, b"com.example")
    for _ in range(2000):
        graph = field(1 << 3 | 2, inner)
        inner = field(5 << 3 | 2, field(6 << 3 | 2, graph))
    with pytest.raises(Refused, match=INNER):
        audit(field(7 << 3 | 2, field(1 << 3 | 2, inner)))


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (network(LAST) + network(LAST), "field 7 occurs 2 times"),  # other parsers put the two graphs together
        (b"\xba\x80\x80\x80\x10" + network(LAST)[1:], "no field at byte"),  # 2**32 more than the graph's field
        (b"\x02\x01a", "no field at byte 1"),
        (field(7 << 3 | 2, b"\x08\x01"), "field 1 is not a message"),
        (field(7 << 3 | 2, b"\x0d\x01\x01\x01\x01"), "field 1 is not a message"),
        (field(7 << 3 | 2, field(1 << 3 | 2, field(4 << 3 | 2, b"Relu") * 2)), "field 4 occurs 2 times"),
        (field(7 << 3 | 2, field(1 << 3 | 2, field(4 << 3 | 2, b"\xff"))), "invalid start byte"),
        (b"\x12\x00" * 200_001, "more than 200,000 parts"),
        (b"\x0b", "wire type 3"),
    ],
)
def test_what_two_parsers_could_read_in_two_ways_is_refused(model: bytes, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        audit(model)
