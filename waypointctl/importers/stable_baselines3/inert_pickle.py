"""Reading the numbers in a pickle without making its objects: nothing that it names is imported or called."""

from __future__ import annotations

import io
import pickle
import pickletools
import re
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]

MOST_OPERATIONS: Final = 200_000  # of a pickle; a policy's tensors and a VecNormalize take some thousand

_PLAIN_NUMBER: Final = re.compile(r"[fiu][1248]")
_BYTE_ORDERS: Final = ("<", ">", "|", "=")


class Inert:
    """Placeholder of an object of any class: the arguments it would be made with, and the state put into it.

    Attributes:
        origin: "module.name" of the class or function that the pickle names.
        args: given to it.
        state: given to its __setstate__, None if there is none.
    """

    origin = ""
    args: tuple[Any, ...]
    state: Any

    def __new__(cls, *args: Any, **kwargs: Any) -> Inert:
        """Keep the arguments, however the pickle calls: as a constructor, or as a function that returns something."""
        made = super().__new__(cls)
        made.args, made.state = args, None
        return made

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        """Everything is kept by __new__ already, which is all that some of pickle's calls come to."""

    def __setstate__(self, state: Any) -> None:
        """Keep the state."""
        self.state = state

    # What containers are filled with is of no interest here.
    def __setitem__(self, key: Any, value: Any) -> None:
        """Drop an item."""

    def append(self, value: Any) -> None:
        """Drop a value."""

    def extend(self, values: Any) -> None:
        """Drop values."""

    def add(self, value: Any) -> None:
        """Drop a value."""


class _Items(dict[Any, Any]):
    """An OrderedDict, without what is set on it beside its items."""

    def __setstate__(self, state: Any) -> None:
        """Drop the state."""


class _Reader(pickle.Unpickler):
    def find_class(self, module: str, name: str, /) -> type[Inert] | type[_Items]:
        # The only place that could load code: no module is imported.
        if (module, name) == ("collections", "OrderedDict"):
            return _Items
        return type(name, (Inert,), {"origin": f"{module}.{name}"})

    def persistent_load(self, pid: Any, /) -> Inert:
        return Inert(*pid) if isinstance(pid, tuple) else Inert(pid)


def read_inert(pickled: bytes) -> Any:
    """Return what a pickle describes: numbers, text, lists and dicts as they are, all else as `Inert`.

    Raises:
        ValueError: it is not a pickle, or does more than `MOST_OPERATIONS`.
    """
    try:
        _refuse_excess(pickled)
        return _Reader(io.BytesIO(pickled)).load()
    except Exception as error:  # unpickling garbage may raise any exception
        raise ValueError(f"it is not a pickle: {str(error) or type(error).__name__}") from error


def origin_of(value: object) -> str:
    """Return "module.name" of what a pickle names, or of what it would make; nothing for plain values."""
    if isinstance(value, Inert):
        return value.origin
    return value.origin if isinstance(value, type) and issubclass(value, Inert) else ""


def _refuse_excess(pickled: bytes) -> None:
    """Refuse a pickle that would take much more memory than it has bytes, before anything is made.

    Raises:
        ValueError: it does.
    """
    for count, (operation, argument, _) in enumerate(pickletools.genops(pickled)):
        if count > MOST_OPERATIONS:
            raise ValueError(f"it does more than {MOST_OPERATIONS:,} operations")
        # The unpickler makes a table as long as the largest number that something is remembered under.
        if operation.name.endswith("PUT") and not (isinstance(argument, int) and 0 <= argument <= MOST_OPERATIONS):
            raise ValueError(f"it uses the memo index {argument}")


def array_of(value: object) -> FloatArray:
    """Return a numpy array or scalar of a pickle, as float64.

    Raises:
        ValueError: it is none, or not of plain numbers.
    """
    match value:
        case bool():
            pass
        case int() | float():
            return np.array(value, np.float64)
        case Inert(origin=origin, args=args, state=state):
            function = origin.rpartition(".")[2]
            if origin.startswith("numpy"):
                return _numpy_array(function, args, state)
    raise ValueError(f"{value.origin if isinstance(value, Inert) else type(value).__name__} is not an array of numbers")


def _numpy_array(function: str, args: tuple[Any, ...], state: Any) -> FloatArray:
    match function, args, state:
        case "_reconstruct", _, (_, tuple(shape), Inert() as dtype, bool(fortran), bytes(content)):
            order = "F" if fortran else "C"
        case "_frombuffer", (bytes() | bytearray() as content, Inert() as dtype, tuple(shape), str(order)), None:
            pass
        case "scalar", (Inert() as dtype, bytes(content)), None:
            shape, order = (), "C"
        case _:
            raise ValueError(f"numpy's {function} is not an array of numbers")
    if not all(type(size) is int and size >= 0 for size in shape) or order not in ("C", "F"):
        raise ValueError("an array has a shape that cannot be")
    numbers = np.frombuffer(content, _dtype(dtype))
    return numbers.reshape(shape, order="F" if order == "F" else "C").astype(np.float64)


def _dtype(inert: Inert) -> np.dtype[Any]:
    match inert.origin, inert.args, inert.state:
        case "numpy.dtype", (str(kind), *_), (_, str(byte_order), *_) if (
            _PLAIN_NUMBER.fullmatch(kind) and byte_order in _BYTE_ORDERS
        ):
            return np.dtype(byte_order + kind)
    raise ValueError("an array has an unsupported number type")
