"""The shapes in a network, found from its graph alone, before any memory is allocated for them.

Operators are an allow-list of deterministic ones: what waypointctl's own export has, and what exported multilayer
perceptrons and recurrent networks need. Shapes that are computed from shapes, as exports of recurrent networks do, are
followed; one that is computed from observations is refused.
Operators: https://onnx.ai/onnx/operators.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import zip_longest
from typing import Final, TypeAlias

import numpy as np

from waypointctl.policy.onnx_graph import ITEM_BYTES
from waypointctl.policy.onnx_values import Given, Shape, of_node
from waypointctl.policy.protobuf_fields import Refused

Rule: TypeAlias = Callable[[Given], Sequence[Shape]]


def _same(given: Given) -> Sequence[Shape]:
    return [given.shape()]


def _broadcast(given: Given) -> Sequence[Shape]:
    return [np.broadcast_shapes(*(given.shape(index) for index in range(len(given.values))))]


def _matmul(given: Given) -> Sequence[Shape]:
    left, right = given.shape(0), given.shape(1)
    wide_left, wide_right = (1, *left) if len(left) == 1 else left, (*right, 1) if len(right) == 1 else right
    if min(len(wide_left), len(wide_right)) < 2 or wide_left[-1] != wide_right[-2]:
        raise ValueError(f"shapes {left} and {right} do not fit")
    batch = np.broadcast_shapes(wide_left[:-2], wide_right[:-2])
    return [(*batch, *(wide_left[-2:-1] if len(left) > 1 else ()), *(wide_right[-1:] if len(right) > 1 else ()))]


def _gemm(given: Given) -> Sequence[Shape]:
    (rows, inner), (inner_too, columns) = (
        given.shape(index)[::-1] if given.number(name, 0) else given.shape(index)
        for index, name in enumerate(("transA", "transB"))
    )
    if inner != inner_too:
        raise ValueError(f"shapes {given.shape(0)} and {given.shape(1)} do not fit")
    return [(rows, columns)]


def _recurrent(given: Given) -> Sequence[Shape]:
    """LSTM, GRU, RNN: all outputs, the last one, and the last cell state, of x (steps, batch, inputs)."""
    x, weights, recurrence = given.shape(), given.shape(1), given.shape(2)
    if len(x) != 3 or len(weights) != 3 or len(recurrence) != 3:
        raise ValueError(f"shapes {x}, {weights} and {recurrence} do not fit")
    directions, hidden = weights[0], recurrence[2]
    if given.number("hidden_size", hidden) != hidden:
        raise ValueError(f"hidden_size is not {hidden}")
    if given.number("layout", 0):
        return [(*x[:2], directions, hidden), (x[0], directions, hidden), (x[0], directions, hidden)]
    return [(x[0], directions, x[1], hidden), (directions, x[1], hidden), (directions, x[1], hidden)]


def _reduced(given: Given) -> Sequence[Shape]:
    shape, axes = given.shape(), given.numbers("axes", 1)
    if not axes and given.number("noop_with_empty_axes", 0):
        return [shape]
    gone = {_axis(axis, shape) for axis in axes or range(len(shape))}
    return [_without(shape, gone, given.number("keepdims", 1))]


def _arg(given: Given) -> Sequence[Shape]:
    shape = given.shape()
    return [_without(shape, {_axis(given.number("axis", 0), shape)}, given.number("keepdims", 1))]


def _without(shape: Shape, gone: set[int], keep: int) -> Shape:
    return tuple(1 if axis in gone else side for axis, side in enumerate(shape) if keep or axis not in gone)


def _constant(given: Given) -> Sequence[Shape]:
    return [of_node(given).shape]


def _cast(given: Given) -> Sequence[Shape]:
    if given.number("to", 0) not in ITEM_BYTES:
        raise Refused("numbers that are not float, int32, int64 or bool")
    return _same(given)


def _dropout(given: Given) -> Sequence[Shape]:
    if given.has(2):  # whether it is training
        raise Refused("the operator 'Dropout' with a training_mode")
    return _same(given)


def _shape_of(given: Given) -> Sequence[Shape]:
    shape = given.shape()
    return [(len(shape[given.number("start", 0) : given.number("end", len(shape))]),)]


def _target(given: Given, index: int = 1) -> tuple[int, ...]:
    target = given.numbers("shape", index)
    if target is None:
        raise ValueError("no shape is given")
    return target


def _reshape(given: Given) -> Sequence[Shape]:
    shape = given.shape()
    copied = not given.number("allowzero", 0)
    target = [
        shape[axis] if side == 0 and copied and axis < len(shape) else side for axis, side in enumerate(_target(given))
    ]
    if target.count(-1) == 1:
        others = math.prod(side for side in target if side != -1)
        target[target.index(-1)] = math.prod(shape) // others if others else 0
    if math.prod(target) != math.prod(shape):
        raise ValueError(f"shape {shape} cannot become {tuple(target)}")
    return [tuple(target)]


def _expand(given: Given) -> Sequence[Shape]:
    return [np.broadcast_shapes(given.shape(), _target(given))]


def _constant_of_shape(given: Given) -> Sequence[Shape]:
    return [_target(given, 0)]


def _flatten(given: Given) -> Sequence[Shape]:
    shape, axis = given.shape(), given.number("axis", 1)
    axis += len(shape) if axis < 0 else 0
    return [(math.prod(shape[:axis]), math.prod(shape[axis:]))]


def _transpose(given: Given) -> Sequence[Shape]:
    shape = given.shape()
    order = given.numbers("perm", len(given.values)) or tuple(reversed(range(len(shape))))
    if sorted(order) != list(range(len(shape))):
        raise ValueError(f"shape {shape} cannot be turned by {order}")
    return [tuple(shape[axis] for axis in order)]


def _squeeze(given: Given) -> Sequence[Shape]:
    shape, axes = given.shape(), given.numbers("axes", 1)
    gone = {_axis(axis, shape) for axis in axes} if axes else {axis for axis, side in enumerate(shape) if side == 1}
    if any(shape[axis] != 1 for axis in gone):
        raise ValueError(f"shape {shape} has no dimension of size 1 at {axes}")
    return [tuple(side for axis, side in enumerate(shape) if axis not in gone)]


def _unsqueeze(given: Given) -> Sequence[Shape]:
    shape = list(given.shape())
    axes = given.numbers("axes", 1) or ()
    for axis in sorted(axis + len(shape) + len(axes) if axis < 0 else axis for axis in axes):
        shape.insert(axis, 1)
    return [tuple(shape)]


def _concat(given: Given) -> Sequence[Shape]:
    first = given.shape()
    axis = _axis(given.number("axis", 0), first)
    shapes = [given.shape(index) for index in range(len(given.values))]
    if any(shape[:axis] != first[:axis] or shape[axis + 1 :] != first[axis + 1 :] for shape in shapes):
        raise ValueError(f"shapes {shapes} do not fit")
    return [(*first[:axis], sum(shape[axis] for shape in shapes), *first[axis + 1 :])]


def _split(given: Given) -> Sequence[Shape]:
    shape, count = given.shape(), len(given.node.outputs)
    axis = _axis(given.number("axis", 0), shape)
    parts = given.numbers("split", 1)
    if parts is None:
        each = -(-shape[axis] // count)
        parts = tuple(min(each, max(shape[axis] - each * index, 0)) for index in range(count))
    if sum(parts) != shape[axis] or len(parts) != count or min(parts) < 0:
        raise ValueError(f"shape {shape} cannot be split into {parts}")
    return [(*shape[:axis], part, *shape[axis + 1 :]) for part in parts]


def _slice(given: Given) -> Sequence[Shape]:
    shape = list(given.shape())
    starts, ends = given.numbers("starts", 1), given.numbers("ends", 2)
    axes, steps = given.numbers("axes", 3), given.numbers("steps", 4)
    if starts is None or ends is None:
        raise ValueError("no starts or ends are given")
    for start, end, axis, step in zip_longest(starts, ends, axes or range(len(starts)), steps or (1,) * len(starts)):
        at = _axis(axis, tuple(shape))
        shape[at] = len(range(*slice(start, None if step < 0 and end < -shape[at] else end, step).indices(shape[at])))
    return [tuple(shape)]


def _gather(given: Given) -> Sequence[Shape]:
    shape = given.shape()
    axis = _axis(given.number("axis", 0), shape)
    return [(*shape[:axis], *given.shape(1), *shape[axis + 1 :])]


def _axis(axis: int | None, shape: Shape) -> int:
    if axis is None or not -len(shape) <= axis < len(shape):
        raise ValueError(f"shape {shape} has no axis {axis}")
    return axis % len(shape)


_ALONE: Final = (  # each number by itself, or along an axis
    "Identity Neg Abs Sign Floor Ceil Round Sqrt Reciprocal Exp Log Erf Sin Cos Tan Asin Acos Atan Sinh Cosh Asinh "
    "Acosh Atanh Relu LeakyRelu ThresholdedRelu Elu Selu Celu Gelu Sigmoid HardSigmoid HardSwish Mish Swish Tanh "
    "Softplus Softsign Softmax LogSoftmax Clip Not IsNaN LayerNormalization RMSNormalization BatchNormalization "
    "LpNormalization"
)
_TOGETHER: Final = (
    "Add Sub Mul Div Mod Pow Min Max Sum Mean PRelu Where Equal Greater GreaterOrEqual Less LessOrEqual And Or Xor"
)
_REDUCTIONS: Final = (
    "ReduceMean ReduceSum ReduceMax ReduceMin ReduceProd ReduceL1 ReduceL2 ReduceSumSquare ReduceLogSum ReduceLogSumExp"
)
RULES: Final[Mapping[str, Rule]] = {
    **dict.fromkeys(_ALONE.split(), _same),
    **dict.fromkeys(_TOGETHER.split(), _broadcast),
    **dict.fromkeys(_REDUCTIONS.split(), _reduced),
    **dict.fromkeys(("LSTM", "GRU", "RNN"), _recurrent),
    **dict.fromkeys(("ArgMax", "ArgMin"), _arg),
    "MatMul": _matmul,
    "Gemm": _gemm,
    "Constant": _constant,
    "ConstantOfShape": _constant_of_shape,
    "Cast": _cast,
    "Dropout": _dropout,
    "Shape": _shape_of,
    "Reshape": _reshape,
    "Expand": _expand,
    "Flatten": _flatten,
    "Transpose": _transpose,
    "Squeeze": _squeeze,
    "Unsqueeze": _unsqueeze,
    "Concat": _concat,
    "Split": _split,
    "Slice": _slice,
    "Gather": _gather,
}
