from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from onnx import AttributeProto, GraphProto, ModelProto, NodeProto, SparseTensorProto, TensorProto, helper

from waypointctl.policy.onnx_audit import unsafe_parts

ELSEWHERE = "a tensor kept in another file"
FOREIGN = "operators of the domain 'com.example'"


def outside() -> TensorProto:
    tensor = TensorProto(name="weight", data_type=TensorProto.FLOAT, dims=[2])
    tensor.data_location = TensorProto.EXTERNAL
    tensor.external_data.add(key="location", value="/etc/passwd")
    return tensor


def foreign(name: str = "Call") -> NodeProto:
    return helper.make_node(name, ["x"], ["y"], domain="com.example")


def model_of(graph: GraphProto) -> ModelProto:
    return ModelProto(ir_version=8, graph=graph, opset_import=[helper.make_opsetid("", 17)])


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
        (lambda: model_of(GraphProto(sparse_initializer=[SparseTensorProto(values=outside())])), ELSEWHERE),
        (lambda: holding(AttributeProto(name="value", t=outside())), ELSEWHERE),
        (lambda: holding(AttributeProto(name="values", tensors=[outside()])), ELSEWHERE),
        (lambda: holding(AttributeProto(name="then_branch", g=GraphProto(initializer=[outside()]))), ELSEWHERE),
        (lambda: model_of(GraphProto(node=[foreign()])), FOREIGN),
        (lambda: holding(AttributeProto(name="then_branch", g=GraphProto(node=[foreign()]))), FOREIGN),
        (lambda: holding(AttributeProto(name="branches", graphs=[GraphProto(node=[foreign()])])), FOREIGN),
        (with_function, FOREIGN),
        (with_training, FOREIGN),
        (lambda: ModelProto(opset_import=[helper.make_opsetid("com.example", 1)]), FOREIGN),
    ],
)
def test_it_finds_them_wherever_onnx_can_hold_them(make: Callable[[], ModelProto], expected: str) -> None:
    assert unsafe_parts(make().SerializeToString()) == [expected]


def test_each_is_told_once() -> None:
    model = model_of(GraphProto(node=[foreign("A"), foreign("B")], initializer=[outside(), outside()]))
    assert sorted(unsafe_parts(model.SerializeToString())) == [ELSEWHERE, FOREIGN]


def test_standard_operators_and_weights_inside_pass() -> None:
    weight = helper.make_tensor("weight", TensorProto.FLOAT, [2], [1.0, 2.0])
    loop = helper.make_node("Loop", ["x"], ["y"], body=GraphProto(name="body", initializer=[weight]))
    elu = helper.make_node("Elu", ["y"], ["z"], domain="ai.onnx", alpha=1.0)
    model = model_of(GraphProto(node=[loop, elu], initializer=[weight]))
    assert unsafe_parts(model.SerializeToString()) == []


def test_a_truncated_model_is_refused() -> None:
    whole = model_of(GraphProto(node=[helper.make_node("Elu", ["x"], ["y"])])).SerializeToString()
    with pytest.raises(ValueError, match="after its message"):
        unsafe_parts(whole[: len(whole) // 2])


@given(st.binary(max_size=200))
def test_any_bytes_are_walked_or_refused(content: bytes) -> None:
    try:
        unsafe_parts(content)
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
    node = field(7 << 3 | 2, b"com.example")
    for _ in range(2000):
        graph = field(1 << 3 | 2, node)
        node = field(5 << 3 | 2, field(6 << 3 | 2, graph))
    assert unsafe_parts(field(7 << 3 | 2, field(1 << 3 | 2, node))) == [FOREIGN]
