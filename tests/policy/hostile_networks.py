"""Networks that draw, repeat or grow without bound, and how a policy's network is put together by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
from onnx import AttributeProto, GraphProto, ModelProto, NodeProto, TensorProto, helper, numpy_helper

INNER = "a graph within a graph"


def model_of(graph: GraphProto) -> ModelProto:
    return ModelProto(ir_version=8, graph=graph, opset_import=[helper.make_opsetid("", 17)])


def network(*nodes: NodeProto, **constants: Any) -> bytes:
    """Return a model from "x", (n, 31), to "y", (n, 8); "w" is a matrix that leads there."""
    arrays = {"w": np.full((31, 8), 0.1, np.float32)} | constants
    graph = helper.make_graph(
        nodes,
        "g",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, ["n", 31])],
        [helper.make_tensor_value_info("y", TensorProto.FLOAT, ["n", 8])],
        [numpy_helper.from_array(np.asarray(array), name) for name, array in arrays.items()],
    )
    return model_of(graph).SerializeToString()


def node(operator: str, inputs: str, output: str, **attributes: Any) -> NodeProto:
    return helper.make_node(operator, inputs.split(), output.split(), **attributes)


LAST = node("MatMul", "x w", "y")


def sized(*sides: int) -> np.ndarray[Any, Any]:
    return np.array(sides, np.int64)


ENLARGED = node("ConstantOfShape", "k", "c")


def _two_values(first: str, second: str) -> NodeProto:
    """Return a constant of which one reader sees one number, and onnxruntime 2**28."""
    constant = node("Constant", "", "k", **{first: [2**28]})
    value = numpy_helper.from_array(sized(1)) if second == "value" else [1]
    constant.attribute.append(helper.make_attribute(second, value))
    return constant


def _of_another_type() -> NodeProto:
    constant = node("Constant", "", "k", value_ints=[1])
    constant.attribute[0].type = AttributeProto.INT
    return constant


HOSTILE: dict[str, tuple[bytes, str]] = {
    "ConstantOfShape": (network(node("ConstantOfShape", "s", "c"), LAST, s=sized(2**20, 2**20)), "in a tensor"),
    "many ConstantOfShape": (
        network(*[node("ConstantOfShape", "s", f"c{n}") for n in range(5)], LAST, s=sized(2**24)),
        "in all",
    ),
    "Expand": (network(node("Expand", "w s", "c"), LAST, s=sized(2**20, 31, 8)), "in a tensor"),
    "Expand and reduce": (
        network(node("Expand", "x s", "c"), node("ReduceMax", "c", "y", axes=[0]), s=sized(2**20, 1, 1)),
        "in a tensor",
    ),
    "outer product": (
        network(node("MatMul", "a b", "c"), LAST, a=np.ones((5000, 1), np.float32), b=np.ones((1, 5000), np.float32)),
        "in a tensor",
    ),
    "broadcast": (
        network(node("Add", "a b", "c"), LAST, a=np.ones((5000, 1), np.float32), b=np.ones((1, 5000), np.float32)),
        "in a tensor",
    ),
    "concatenated again and again": (
        network(
            *[node("Concat", f"c{n} c{n}", f"c{n + 1}", axis=0) for n in range(40)], LAST, c0=np.ones(9, np.float32)
        ),
        "in a tensor|in all",
    ),
    "shape of the observation": (
        network(node("Cast", "x", "s", to=7), node("ConstantOfShape", "s", "c"), LAST),
        "a shape that is not known before it runs, in the operator 'ConstantOfShape'",
    ),
    "large for fewer observations": (
        network(
            *[node("Shape", "x", "s"), node("Gather", "s i", "n"), node("Equal", "n many", "e")],
            *[node("Where", "e small large", "k"), node("ConstantOfShape", "k", "c"), LAST],
            i=sized(0),
            many=sized(256),
            small=sized(1),
            large=sized(2**28),
        ),
        "in a tensor",
    ),
    "constant of two values": (
        network(_two_values("value_ints", "value"), ENLARGED, LAST),
        "a constant of no value, or",
    ),
    "attribute twice": (
        network(_two_values("value_ints", "value_ints"), ENLARGED, LAST),
        "'value_ints' occurs twice",
    ),
    "attribute of another type": (network(_of_another_type(), ENLARGED, LAST), "has another type than declared"),
    "constant that another one replaces": (
        network(ENLARGED, node("Constant", "", "k", value_ints=[2**28]), LAST, k=sized(1)),
        "gives 'k', which already exists",
    ),
    "Tile": (network(node("Tile", "x s", "c"), LAST, s=sized(2**30, 1)), "the operator 'Tile'"),
    "Pad": (network(node("Pad", "x s", "c"), LAST, s=sized(0, 0, 0, 2**40)), "the operator 'Pad'"),
    "Range": (
        network(node("Range", "a b c", "d"), LAST, a=0.0, b=1e12, c=1.0),
        "numbers that are not|the operator 'Ran",
    ),
    "OneHot": (network(node("OneHot", "a b c", "d"), LAST, a=sized(1), b=sized(2**40), c=sized(0, 1)), "'OneHot'"),
    "EyeLike": (network(node("EyeLike", "x", "d"), LAST), "the operator 'EyeLike'"),
    "Loop": (network(node("Loop", "a ", "d", body=GraphProto(name="b")), LAST, a=sized(2**62)), INNER),
    "Scan": (network(node("Scan", "x", "d", body=GraphProto(name="b"), num_scan_inputs=1), LAST), INNER),
    "If": (network(node("If", "a", "d", then_branch=GraphProto(), else_branch=GraphProto()), LAST, a=True), INNER),
    **{
        name: (network(node(name, "x", "r"), node("MatMul", "r w", "y")), f"the operator '{name}'")
        for name in ("RandomNormalLike", "RandomUniformLike", "Bernoulli", "Multinomial", "NonZero", "Conv", "Unique")
    },
    "RandomNormal": (network(node("RandomNormal", "", "r", shape=[1, 31]), LAST), "the operator 'RandomNormal'"),
    "RandomUniform": (network(node("RandomUniform", "", "r", shape=[1, 31]), LAST), "the operator 'RandomUniform'"),
    "Dropout in training": (network(node("Dropout", "x a b", "r"), LAST, a=np.float32(0.5), b=True), "training_mode"),
    "text": (network(node("Cast", "x", "t", to=8), LAST), "numbers that are not float"),
    "whole numbers divided": (
        network(node("Cast", "x", "a", to=7), node("Div", "a a", "b"), LAST),
        "a division of whole numbers",
    ),
    "very many operators": (
        network(*[node("Relu", "x", f"r{n}") for n in range(2001)], LAST),
        "more than 2,000 operat",
    ),
}
