"""The shapes that are found from a graph are those that onnxruntime gives, for every operator that is read."""

from __future__ import annotations

from typing import Any

import numpy as np
import onnxruntime
import pytest
from numpy.typing import NDArray
from onnx import ValueInfoProto, helper, numpy_helper

from waypointctl.policy.onnx_audit import output_values
from waypointctl.policy.onnx_graph import read_graph
from waypointctl.policy.onnx_shapes import RULES
from waypointctl.policy.onnx_values import Value, constant
from waypointctl.policy.protobuf_fields import Refused

Array = NDArray[Any]
TYPES = {"float32": 1, "int32": 6, "int64": 7, "bool": 9, "float64": 11}


def floats(*shape: int) -> Array:
    return np.linspace(-0.9, 0.9, int(np.prod(shape)), dtype=np.float32).reshape(shape)


def whole(*values: Any) -> Array:
    return np.array(values, np.int64)


X = floats(6, 5)
CUBE = floats(2, 3, 4)

ALONE = (
    "Identity Neg Abs Sign Floor Ceil Round Sqrt Reciprocal Exp Log Erf Sin Cos Tan Asin Acos Atan Sinh Cosh Asinh "
    "Acosh Atanh Relu LeakyRelu ThresholdedRelu Elu Selu Celu Sigmoid HardSigmoid HardSwish Mish Tanh Softplus "
    "Softsign Softmax LogSoftmax Clip IsNaN LpNormalization Flatten Shape Transpose ArgMax ArgMin"
)
PRODUCTS = (
    ((6, 5), (5, 3)),
    ((5,), (5, 3)),
    ((6, 5), (5,)),
    ((5,), (5,)),
    ((2, 6, 5), (5, 3)),
    ((7, 1, 6, 5), (2, 5, 3)),
)
# operator, inputs (None: left out; the first one is not known before the network runs), attributes, outputs, opset
CASES: list[Any] = [
    *[(name, [X], {}, 1, 18) for name in ALONE.split()],
    ("Gelu", [X], {}, 1, 20),
    ("Swish", [X], {}, 1, 24),
    ("Dropout", [X], {}, 1, 18),
    ("Dropout", [X, np.float32(0.5).reshape(())], {}, 1, 18),
    ("Clip", [X, None, np.array(0.5, np.float32)], {}, 1, 18),
    ("Not", [X > 0], {}, 1, 18),
    ("LayerNormalization", [X, floats(5), floats(5)], {}, 1, 18),
    ("RMSNormalization", [X, floats(5)], {}, 1, 23),
    ("BatchNormalization", [X, *[np.abs(floats(5)) for _ in range(4)]], {}, 1, 18),
    *[(name, [X, floats(1, 5)], {}, 1, 18) for name in (
        "Add", "Sub", "Mul", "Div", "Pow", "Min", "Max", "Sum", "Mean", "PRelu", "Equal", "Greater", "GreaterOrEqual",
        "Less", "LessOrEqual")],
    ("Add", [floats(5), CUBE[..., :1]], {}, 1, 18),
    ("Max", [X, floats(1), floats(6, 1)], {}, 1, 18),
    ("Mod", [X, floats(5)], {"fmod": 1}, 1, 18),
    *[(name, [X > 0, X[:1] > 0], {}, 1, 18) for name in ("And", "Or", "Xor")],
    ("Where", [X > 0, floats(1, 5), np.array(0, np.float32)], {}, 1, 18),
    ("Cast", [X], {"to": 7}, 1, 18),
    *[("MatMul", [floats(*left), floats(*right)], {}, 1, 18) for left, right in PRODUCTS],
    ("Gemm", [X, floats(5, 3), floats(3)], {}, 1, 18),
    ("Gemm", [X, floats(3, 6)], {"transA": 1, "transB": 1}, 1, 18),
    ("Reshape", [X, whole(3, 10)], {}, 1, 18),
    ("Reshape", [X, whole(0, -1, 1)], {}, 1, 18),
    ("Reshape", [CUBE, whole(-1)], {}, 1, 18),
    ("Flatten", [CUBE], {"axis": 2}, 1, 18),
    ("Flatten", [CUBE], {"axis": -1}, 1, 18),
    ("Flatten", [CUBE], {"axis": 0}, 1, 18),
    ("Transpose", [CUBE], {"perm": [1, 0, 2]}, 1, 18),
    ("Squeeze", [floats(1, 6, 1)], {}, 1, 18),
    ("Squeeze", [floats(1, 6, 1), whole(-1)], {}, 1, 18),
    ("Squeeze", [floats(1, 6, 1)], {"axes": [0]}, 1, 12),
    ("Unsqueeze", [X, whole(-1, 0)], {}, 1, 18),
    ("Unsqueeze", [X], {"axes": [1]}, 1, 12),
    ("Concat", [X, floats(2, 5)], {"axis": 0}, 1, 18),
    ("Concat", [X, floats(6, 3), floats(6, 1)], {"axis": -1}, 1, 18),
    ("Split", [X], {"axis": 1, "num_outputs": 2}, 2, 18),
    ("Split", [X, whole(1, 4)], {"axis": -1}, 2, 18),
    ("Split", [X], {"axis": 0}, 3, 13),
    ("Split", [X], {"axis": 0, "split": [2, 4]}, 2, 11),
    ("Slice", [X, whole(1), whole(4)], {}, 1, 18),
    ("Slice", [X, whole(-1), whole(-(2**63) + 1), whole(1), whole(-2)], {}, 1, 18),
    ("Slice", [X, whole(1, 0), whole(2**62, -1), whole(1, 0)], {}, 1, 18),
    ("Slice", [X], {"starts": [1], "ends": [3], "axes": [1]}, 1, 9),
    ("Gather", [X, whole(0, 3)], {"axis": 1}, 1, 18),
    ("Gather", [X, np.array(1)], {}, 1, 18),
    ("Gather", [X, np.array([[0, 1], [2, 3]])], {}, 1, 18),
    ("Shape", [CUBE], {"start": 1}, 1, 18),
    ("Shape", [CUBE], {"start": -2, "end": -1}, 1, 18),
    ("Expand", [floats(1, 5), whole(6, 1)], {}, 1, 18),
    ("Expand", [X, whole(2, 1, 1)], {}, 1, 18),
    ("Constant", [], {"value_ints": [1, 2, 3]}, 1, 18),
    ("Constant", [], {"value_floats": [1.0, 2.0]}, 1, 18),
    ("Constant", [], {"value_float": 1.0}, 1, 18),
    ("Constant", [], {"value": numpy_helper.from_array(CUBE)}, 1, 18),
    *[(name, [CUBE], {"axes": [1]}, 1, 11) for name in RULES if name.startswith("Reduce")],
    *[(name, [CUBE, whole(-1, 0)], {"keepdims": 0}, 1, 18) for name in RULES if name.startswith("Reduce")],
    ("ReduceSum", [CUBE], {"noop_with_empty_axes": 1}, 1, 18),
    ("ReduceSum", [CUBE], {"keepdims": 0}, 1, 18),
    ("ArgMax", [CUBE], {"axis": -1, "keepdims": 0}, 1, 18),
]  # fmt: skip
RECURRENT = [("LSTM", 4, 3), ("GRU", 3, 2), ("RNN", 1, 2)]
for operator, gates, count in RECURRENT:
    for directions in (1, 2):
        CASES.append(
            (
                operator,
                [floats(5, 2, 4), floats(directions, gates * 3, 4), floats(directions, gates * 3, 3)],
                {"hidden_size": 3, "direction": "bidirectional" if directions == 2 else "forward"},
                count,
                18,
            )
        )


def model_of(operator: str, inputs: list[Array | None], attributes: dict[str, Any], count: int, opset: int) -> Any:
    names = [f"i{index}" if array is not None else "" for index, array in enumerate(inputs)]
    outputs = [f"o{index}" for index in range(count)]
    first = (
        [helper.make_tensor_value_info("i0", TYPES[str(inputs[0].dtype)], None)]
        if inputs and inputs[0] is not None
        else []
    )
    constants = [
        numpy_helper.from_array(np.asarray(array), name)
        for name, array in zip(names[1:], inputs[1:], strict=True)
        if array is not None
    ]
    graph = helper.make_graph(
        [helper.make_node(operator, names, outputs, **attributes)],
        "one",
        first,
        [ValueInfoProto(name=name) for name in outputs],
        constants,
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", opset)], ir_version=8)


@pytest.mark.parametrize("case", CASES, ids=[f"{number}-{case[0]}" for number, case in enumerate(CASES)])
def test_a_shape_is_the_one_that_onnxruntime_gives(case: tuple[Any, ...]) -> None:
    operator, inputs, attributes, count, opset = case
    content = model_of(operator, inputs, attributes, count, opset).SerializeToString()
    options = onnxruntime.SessionOptions()
    options.log_severity_level = 4
    session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    expected = session.run(None, {"i0": inputs[0]} if inputs else {})
    graph = read_graph(content)
    values: dict[str, Value] = {each.name: constant(each) for each in graph.constants}
    if inputs:
        values["i0"] = Value(inputs[0].shape, TYPES[str(inputs[0].dtype)])
    (node,) = graph.nodes
    found, work = output_values(node, [values[name] if name else None for name in node.inputs])
    assert [value.shape for value in found][:count] == [array.shape for array in expected]
    assert TYPES[str(expected[0].dtype)] == found[0].type
    assert work >= sum(array.size for array in expected)
    if found[0].known is not None:
        np.testing.assert_array_equal(found[0].known, expected[0])


def test_every_operator_that_is_read_is_tried() -> None:
    assert {case[0] for case in CASES} | {"ConstantOfShape"} == RULES.keys()


def test_what_no_shape_is_known_of_is_refused() -> None:
    graph = read_graph(model_of("Reshape", [X, whole(3, 10)], {}, 1, 18).SerializeToString())
    with pytest.raises(Refused, match="a shape that is not known before it runs, in the operator 'Reshape'"):
        output_values(graph.nodes[0], [Value((6, 5)), Value((2,), 7)])
    graph = read_graph(model_of("NonZero", [X], {}, 1, 18).SerializeToString())
    with pytest.raises(Refused, match="the operator 'NonZero'"):
        output_values(graph.nodes[0], [Value((6, 5))])


def test_a_division_of_whole_numbers_that_could_end_the_program_is_refused() -> None:
    for operator in ("Div", "Mod"):
        (node,) = read_graph(model_of(operator, [whole(6, 5), whole(0, 1)], {}, 1, 18).SerializeToString()).nodes
        for divisor in (None, whole(0, 1), whole(-1, 1)):
            with pytest.raises(Refused, match="a division of whole numbers"):
                output_values(node, [Value((2,), 7, whole(6, 5)), Value((2,), 7, divisor)])
        (found,), _ = output_values(node, [Value((2,), 7, whole(6, 5)), Value((2,), 7, whole(4, 3))])
        np.testing.assert_array_equal(found.known, [1, 1] if operator == "Div" else [2, 2])
