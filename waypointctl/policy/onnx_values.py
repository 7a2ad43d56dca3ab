"""Inputs and outputs of a network's operator, as far as known before the network runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from waypointctl.policy.onnx_graph import BOOL, FLOAT, INT64, Integers, Node, Tensor
from waypointctl.policy.protobuf_fields import MOST_INTEGERS, Refused

Shape: TypeAlias = tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Value:
    """A tensor: its shape, the number of its element type, and its numbers where they are few, int64 and constant."""

    shape: Shape
    type: int = FLOAT
    known: Integers | None = None


@dataclass(frozen=True, slots=True)
class Given:
    """An operator's use, with the values that it takes; None for one that is left out."""

    node: Node
    values: Sequence[Value | None]

    def has(self, index: int) -> bool:
        """Return whether an input is given."""
        return index < len(self.values) and self.values[index] is not None

    def value(self, index: int = 0) -> Value:
        """Return an input."""
        value = self.values[index] if index < len(self.values) else None
        if value is None:
            raise ValueError(f"input {index} is missing")
        return value

    def shape(self, index: int = 0) -> Shape:
        """Return an input's shape."""
        return self.value(index).shape

    def number(self, name: str, default: int) -> int:
        """Return an attribute that is a whole number."""
        value = self.node.attributes.get(name, default)
        if not isinstance(value, int):
            raise ValueError(f"{name} is not a whole number")
        return value

    def numbers(self, name: str, index: int) -> tuple[int, ...] | None:
        """Return whole numbers that are an attribute, or an input in later versions; None if they are left out.

        Raises:
            Refused: they are computed from what is not known before the network runs.
        """
        if self.has(index):
            known = self.value(index).known
            if known is None:
                raise Refused(f"a shape that is not known before it runs, in the operator {self.node.operator!r}")
            return tuple(int(each) for each in known.reshape(-1))
        value = self.node.attributes.get(name)
        return value if isinstance(value, tuple) else None


def constant(tensor: Tensor) -> Value:
    """Return a constant tensor as a value."""
    return Value(tensor.shape, tensor.type, tensor.known)


def of_node(given: Given) -> Value:
    """Return the value of a node that is a constant."""
    attributes = given.node.attributes
    if len(attributes) != 1:  # onnxruntime takes the first, whatever it is
        raise Refused("a constant of no value, or of several")
    value = next((attributes[name] for name in ("value", "value_float", "value_floats") if name in attributes), None)
    if isinstance(value, Tensor):
        return constant(value)
    whole = attributes.get("value_ints", attributes.get("value_int"))
    if not isinstance(whole, int | tuple):
        raise Refused("a constant that is not of numbers")
    return Value(np.shape(whole), INT64, np.array(whole, np.int64))


def element_type(given: Given) -> int:
    """Return the number of the element type of what an operator gives."""
    operator = given.node.operator
    if operator in _COMPARISONS:
        return BOOL
    if operator in ("Shape", "ArgMax", "ArgMin"):
        return INT64
    if operator == "Cast":
        return given.number("to", 0)
    if operator == "Constant":
        return of_node(given).type
    if operator == "ConstantOfShape":
        value = given.node.attributes.get("value")
        return value.type if isinstance(value, Tensor) else FLOAT
    return given.value(1 if operator == "Where" else 0).type


def folded(given: Given, shape: Shape, kind: int) -> Integers | None:
    """Return the numbers that an operator gives, where they are known: whole ones, that shapes are computed from."""
    operator, size = given.node.operator, int(np.prod(shape, dtype=object))
    if size > MOST_INTEGERS or kind not in (INT64, BOOL) or operator not in _FOLDS:
        return None
    if operator in ("Shape", "Constant"):
        arrays: list[Integers] = []
    elif any(value is None or value.known is None for value in given.values):
        return None
    else:
        arrays = [value.known for value in given.values if value is not None and value.known is not None]
    with np.errstate(all="ignore"):  # an overflowing size is refused by its value
        found = _FOLDS[operator](given, arrays)
    return None if found is None else np.asarray(found, np.int64).reshape(shape)


Fold: TypeAlias = Callable[[Given, list[Integers]], Integers | None]


def _shape(given: Given, _: list[Integers]) -> Integers:
    shape = given.shape()
    return np.array(shape[given.number("start", 0) : given.number("end", len(shape))], np.int64)


def _cast(given: Given, arrays: list[Integers]) -> Integers:
    return arrays[0] if given.number("to", 0) == INT64 else np.asarray(arrays[0] != 0, np.int64)


def _divided(given: Given, arrays: list[Integers]) -> Integers | None:
    if (arrays[0] < 0).any() or (arrays[1] <= 0).any():
        return None
    return arrays[0] // arrays[1] if given.node.operator == "Div" else arrays[0] % arrays[1]


def _taken(given: Given, arrays: list[Integers]) -> Integers:
    return np.take(arrays[0], arrays[1], axis=given.number("axis", 0))


def _sliced(given: Given, arrays: list[Integers]) -> Integers | None:
    starts, ends = given.numbers("starts", 1), given.numbers("ends", 2)
    steps = given.numbers("steps", 4) or (1,)
    if arrays[0].ndim != 1 or starts is None or ends is None or steps[0] < 1:
        return None
    return arrays[0][starts[0] : ends[0] : steps[0]]


_COMPARISONS: Final = frozenset(
    ("Equal", "Greater", "GreaterOrEqual", "Less", "LessOrEqual", "Not", "And", "Or", "Xor", "IsNaN")
)
_FOLDS: Final[Mapping[str, Fold]] = {
    "Shape": _shape,
    "Constant": lambda given, _: of_node(given).known,
    "Gather": _taken,
    "Slice": _sliced,
    "Concat": lambda given, arrays: np.concatenate(arrays, axis=given.number("axis", 0)),
    **dict.fromkeys(("Identity", "Squeeze", "Unsqueeze", "Reshape"), lambda _, arrays: arrays[0]),
    "Cast": _cast,
    "Add": lambda _, arrays: arrays[0] + arrays[1],
    "Sub": lambda _, arrays: arrays[0] - arrays[1],
    "Mul": lambda _, arrays: arrays[0] * arrays[1],
    "Div": _divided,
    "Mod": _divided,
    "Equal": lambda _, arrays: np.asarray(arrays[0] == arrays[1], np.int64),
    "Where": lambda _, arrays: np.where(arrays[0] != 0, arrays[1], arrays[2]),
}
