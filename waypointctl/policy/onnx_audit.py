"""Checking an ONNX model before onnxruntime reads it: allowed operators, and bounds of memory and work.

onnxruntime would load operators of foreign domains, read tensors from other files, repeat a loop for ever, draw
random numbers, and allocate the memory of any shape, uninterruptibly. A policy is one file of standard,
deterministic operators whose shapes are known from the graph alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from waypointctl.limits import limit, over_limit
from waypointctl.policy.onnx_graph import FLOAT, INT64, Graph, Node, Port, read_graph
from waypointctl.policy.onnx_shapes import RULES
from waypointctl.policy.onnx_values import Given, Shape, Value, constant, element_type, folded
from waypointctl.policy.protobuf_fields import Refused

ROWS: Final = 256  # observations that the limits are for
MOST_DIMENSIONS: Final = 8
MOST_NODES: Final = 2_000
MOST_NUMBERS: Final = 2**24  # of one tensor, and 4 times as many of all that are computed
LIMIT: Final = "policy-work"

_TYPES: Final = {FLOAT: "float", 6: "int32", 7: "int64", 9: "bool", 10: "float16", 11: "double"}


@dataclass(frozen=True, slots=True)
class Audited:
    """A network that may run: (n, inputs) float32 to (n, outputs) float32."""

    inputs: int
    outputs: int
    graph: Graph

    def require(self, rows: int) -> None:
        """Compute every shape for another number of observations: a shape can depend on it in any way.

        Raises:
            Refused, TooLarge, ValueError: as for `audit`.
        """
        given = _evaluated(self.graph, self.inputs, rows).get(self.graph.outputs[0].name)
        if given is None or given.shape != (rows, self.outputs):
            found = "nothing" if given is None else f"shape {given.shape}"
            raise ValueError(f"the output for {rows} observations is {found}, not {(rows, self.outputs)}")


class TooLarge(ValueError):
    """The network takes more multiplications, `work`, than the limit."""

    def __init__(self, work: int) -> None:
        """State the number and the limit."""
        super().__init__(over_limit(LIMIT, work, f"multiplications for {ROWS} observations"))
        self.work = work


def audit(model: bytes) -> Audited:
    """Return the sizes of a network that may run.

    Raises:
        Refused: it has what a policy must not have.
        TooLarge: it takes more work than the limit.
        ValueError: it is not an ONNX model, or not one from (n, size) to (n, size).
    """
    graph = read_graph(model)
    if len(graph.inputs) != 1 or len(graph.outputs) != 1:
        raise ValueError(f"{len(graph.inputs)} inputs and {len(graph.outputs)} outputs; a policy has one of each")
    audited = Audited(_width(graph.inputs[0], "input"), _width(graph.outputs[0], "output"), graph)
    audited.require(ROWS)
    return audited


def _evaluated(graph: Graph, into: int, rows: int) -> dict[str, Value]:
    """Return every value of a graph for `rows` observations of `into` numbers."""
    if len(graph.nodes) > MOST_NODES:
        raise Refused(f"more than {MOST_NODES:,} operators")
    values: dict[str, Value] = {each.name: constant(each) for each in graph.constants}
    if len(values) < len(graph.constants):  # readers differ in which of two they use
        raise ValueError("two constants of one name")
    values[graph.inputs[0].name] = Value((rows, into))
    share = max(1.0, rows / ROWS)  # the limit scales with the observations
    most = share * MOST_NUMBERS
    numbers = work = 0
    for node in graph.nodes:
        if missing := [name for name in node.inputs if name and name not in values]:
            raise ValueError(f"{node.operator[:40]} takes {missing[0][:80]!r}, which no operator before it produces")
        if doubled := [name for name in node.outputs if name and name in values]:
            raise ValueError(f"{node.operator[:40]} gives {doubled[0][:80]!r}, which already exists")
        try:
            found, more = output_values(node, [values[name] if name else None for name in node.inputs])
        except Refused:
            raise
        except (ValueError, IndexError, TypeError, OverflowError, ZeroDivisionError) as error:
            raise ValueError(f"the operator {node.operator} does not fit what it takes: {error}") from error
        sizes = [math.prod(value.shape) for value in found]
        numbers, work = numbers + sum(sizes), work + more
        if max(sizes, default=0) > most or numbers > 4 * most:
            raise Refused(f"more than {MOST_NUMBERS:,} numbers in a tensor, or {4 * MOST_NUMBERS:,} in all")
        values |= zip(node.outputs, found, strict=False)
    if work > share * limit(LIMIT):  # at the end, so that the message has the total
        raise TooLarge(math.ceil(work / share))
    return values


def output_values(node: Node, values: Sequence[Value | None]) -> tuple[list[Value], int]:
    """Return what an operator gives, and how many multiplications it takes, no less than it gives numbers.

    Raises:
        Refused: the operator is not read, or its shape cannot be known.
        ValueError: its inputs do not fit it.
    """
    if node.operator not in RULES:
        raise Refused(f"the operator {node.operator[:40]!r}")
    given = Given(node, values)
    shapes = [tuple(int(side) for side in shape) for shape in RULES[node.operator](given)]
    if len(node.outputs) > len(shapes):
        raise Refused(f"{len(node.outputs)} outputs of the operator {node.operator!r}")
    if any(len(shape) > MOST_DIMENSIONS or min(shape, default=0) < 0 for shape in shapes):
        raise ValueError(f"an output of shape {shapes}")
    work = sum(map(math.prod, shapes)) + sum(math.prod(value.shape) for value in values if value is not None)
    work += _PRODUCTS[node.operator](given, shapes) if node.operator in _PRODUCTS else 0
    kind = element_type(given)
    known = folded(given, shapes[0], kind) if len(shapes) == 1 else None
    if node.operator in ("Div", "Mod") and kind in _WHOLE and known is None:
        raise Refused("a division of whole numbers")  # by zero it would end the program
    return [Value(shape, kind, known) for shape in shapes], work


def _matmul_work(given: Given, shapes: Sequence[Shape]) -> int:
    return math.prod(shapes[0]) * given.shape(0)[-1]


def _gemm_work(given: Given, shapes: Sequence[Shape]) -> int:
    return math.prod(shapes[0]) * given.shape(0)[0 if given.number("transA", 0) else 1]


def _recurrent_work(given: Given, shapes: Sequence[Shape]) -> int:
    x, weights, hidden = given.shape(), given.shape(1), given.shape(2)[-1]
    return x[0] * x[1] * weights[0] * weights[1] * (weights[2] + hidden)


_WHOLE: Final = (6, INT64)
_PRODUCTS: Final[Mapping[str, Callable[[Given, Sequence[Shape]], int]]] = {
    "MatMul": _matmul_work,
    "Gemm": _gemm_work,
    **dict.fromkeys(("LSTM", "GRU", "RNN"), _recurrent_work),
}


def _width(port: Port, what: str) -> int:
    match port.type, port.shape:
        case 1, (str() | None, int(width)):
            return width
    shape = "any shape" if port.shape is None else f"shape {list(port.shape)}"
    kind = f"tensor({_TYPES.get(port.type, 'other')})"
    raise ValueError(f"the {what} {port.name[:80]!r} is a {kind} of {shape}; a policy's is (n, size) of float32")
