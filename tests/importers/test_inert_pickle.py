from __future__ import annotations

import collections
import os
import pickle
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from waypointctl.importers.stable_baselines3.inert_pickle import Inert, array_of, read_inert


class Malicious:
    """What a pickle can do: loading it creates a file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> Any:
        return (os.mkdir, (str(self.path),))


def test_what_a_pickle_would_call_is_not_called(tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    pickled = pickle.dumps({"harmless": 1, "bad": Malicious(victim)})
    read = read_inert(pickled)
    assert not victim.exists()
    assert (read["harmless"], read["bad"].origin, read["bad"].args) == (1, "posix.mkdir", (str(victim),))
    pickle.loads(pickled)
    assert victim.exists(), "the pickle is a working one"


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_nothing_that_a_pickle_names_is_imported(protocol: int) -> None:
    pickled = pickle.dumps(collections.UserDict(a=1), protocol)
    pickled = pickled.replace(b"collections", b"no_module_1", 1) if protocol else pickled
    assert isinstance(read_inert(pickled), Inert)
    assert "no_module_1" not in sys.modules


@pytest.mark.parametrize("protocol", [3, 4, 5])
@pytest.mark.parametrize("kind", ["<f8", ">f8", "<f4", "<i8", "u1"])
@pytest.mark.parametrize("order", ["C", "F"])
def test_arrays_come_out_as_numpy_put_them_in(protocol: int, kind: str, order: Any) -> None:
    array = np.arange(24).reshape(2, 3, 4).astype(kind, order=order)
    for each in (array, array[:, ::2], array[0, 0, 0], np.zeros((0, 3), kind)):
        np.testing.assert_array_equal(array_of(read_inert(pickle.dumps(each, protocol))), each.astype(np.float64))


@pytest.mark.parametrize("value", [3, 2.5])
def test_a_plain_number_is_an_array_of_no_dimensions(value: float) -> None:
    assert array_of(read_inert(pickle.dumps(value))) == value


@pytest.mark.parametrize(
    "value", [True, "1", None, [1.0], np.array([object]), np.array(["a"]), np.array([1j]), range(3), np.array([True])]
)
def test_what_is_no_array_of_numbers_is_refused(value: object) -> None:
    with pytest.raises(ValueError, match=r"not an array of numbers|unsupported number type"):
        array_of(read_inert(pickle.dumps(value)))


def test_an_array_with_too_few_bytes_is_refused() -> None:
    pickled = pickle.dumps(np.arange(4.0), 4)
    assert b"K\x04" in pickled
    with pytest.raises(ValueError, match="reshape"):
        array_of(read_inert(pickled.replace(b"K\x04\x85", b"K\x09\x85", 1)))


@pytest.mark.parametrize("garbage", [b"", b"hello", b"\x80\x04", b"\x80\x04N", pickle.dumps([1, 2, 3])[:-3], b"PK\x03"])
def test_garbage_is_no_pickle(garbage: bytes) -> None:
    with pytest.raises(ValueError, match="not a pickle"):
        read_inert(garbage)


def test_containers_of_any_class_are_filled_without_harm() -> None:
    filled = [collections.deque([1, 2]), collections.Counter("aab"), {1, 2}]
    kinds = [each.origin if isinstance(each, Inert) else type(each) for each in read_inert(pickle.dumps(filled))]
    assert kinds == ["collections.deque", "collections.Counter", set]


def test_an_ordered_dict_is_a_dict() -> None:
    assert read_inert(pickle.dumps(collections.OrderedDict(a=1))) == {"a": 1}
