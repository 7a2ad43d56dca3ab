"""Files of torch.save(), read without torch: what is in them, and what must not be."""

from __future__ import annotations

import io
import pickle
import zipfile
import zlib
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch

from waypointctl.importers.stable_baselines3.tensors import MOST_TENSORS, read_tensors

MIB = 2**20


def saved(tensors: Any, **options: Any) -> bytes:
    buffer = io.BytesIO()
    torch.save(tensors, buffer, **options)
    return buffer.getvalue()


def repacked(content: bytes, change: Callable[[str, bytes], bytes | None], compression: int = 0) -> bytes:
    """Return a .zip with other content of its parts."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(buffer, "w", compression) as new:
        for name in old.namelist():
            part = change(name, old.read(name))
            if part is not None:
                new.writestr(name, part)
    return buffer.getvalue()


def refused(content: bytes, message: str, most: int = MIB) -> None:
    with pytest.raises(ValueError, match=message):
        read_tensors(content, most)


def test_they_are_what_torch_saved() -> None:
    rng = torch.Generator().manual_seed(1)
    matrix = torch.randn(5, 7, generator=rng)
    tensors = {
        "plain": matrix,
        "turned": matrix.T,
        "cut": matrix[1:4, ::3],
        "one": matrix[2, 3],
        "repeated": torch.randn(1, 4, generator=rng).expand(3, 4),
        "double": matrix.double(),
        "half": matrix.half(),
        "parameter": torch.nn.Parameter(matrix),
        "none": torch.zeros(0, 3),
    }
    for given in (tensors, torch.nn.Linear(3, 2).state_dict()):
        content = saved(given)
        found = read_tensors(content, MIB)
        assert list(found) == list(given)
        for name, tensor in torch.load(io.BytesIO(content), weights_only=True).items():
            np.testing.assert_array_equal(found[name], tensor.detach().numpy(), strict=True)


OTHERS: dict[str, Callable[[], Any]] = {
    "fp8": lambda: torch.zeros(3).to(torch.float8_e4m3fn),
    "fp8 e5m2": lambda: torch.zeros(3).to(torch.float8_e5m2),
    "bfloat16": lambda: torch.zeros(3).bfloat16(),
    "complex": lambda: torch.zeros(3, dtype=torch.complex64),
    "int64": lambda: torch.zeros(3, dtype=torch.int64),
    "bool": lambda: torch.zeros(3, dtype=torch.bool),
    "meta": lambda: torch.zeros(3, device="meta"),
    "sparse": lambda: torch.zeros(3).to_sparse(),
    "quantised": lambda: torch.quantize_per_tensor(torch.zeros(3), 0.1, 0, torch.qint8),
    "nan": lambda: torch.full((3,), torch.nan),
    "infinite": lambda: torch.full((3,), torch.inf),
    "no tensor": lambda: 1,
    "a dict": lambda: {"weight": torch.zeros(3)},
    "a list": lambda: [torch.zeros(3)],
}


@pytest.mark.parametrize("name", OTHERS)
@pytest.mark.filterwarnings("ignore:.*quant.*:DeprecationWarning", "ignore:.*quant.*:UserWarning")
def test_what_is_not_an_array_of_plain_numbers_is_refused_by_name(name: str) -> None:
    refused(saved({"good": torch.zeros(2), "bad": OTHERS[name]()}), "^bad is not an array of finite numbers")


@pytest.mark.parametrize("content", [b"", b"hello", pickle.dumps({}), saved([torch.zeros(2)]), saved(torch.zeros(2))])
def test_what_is_not_tensors_by_name_is_refused(content: bytes) -> None:
    refused(content, "not a .zip that can be read|not tensors by name")


def test_the_old_format_of_torch_is_refused() -> None:
    refused(saved({"a": torch.zeros(2)}, _use_new_zipfile_serialization=False), "not a .zip that can be read")


def test_small_files_that_would_take_much_memory_are_refused() -> None:
    one = torch.zeros(1)
    refused(saved({"bad": one.expand(2**20)}), "^bad makes the tensors larger than what is read, by its shape")
    refused(saved({str(n): one.expand(2**17) for n in range(3)}), "^2 makes the tensors larger")
    refused(saved({str(n): one for n in range(MOST_TENSORS + 1)}), f"{MOST_TENSORS} are read")
    zeros = repacked(saved({"bad": one}), lambda name, part: part if "/data/" not in name else bytes(8 * MIB), 8)
    assert len(zeros) < MIB // 4
    refused(zeros, "^bad archive/data/0 unpacks to more than the 1,048,576 bytes")


@pytest.mark.parametrize(
    ("pickled", "message"),
    [
        (b"]r\xff\xff\xff\x7f.", "it uses the memo index 2147483647"),
        (b"]p2147483647\n.", "it uses the memo index 2147483647"),
        (b"\x80\x02" + b"]0" * 200_000 + b"].", "it does more than 200,000 operations"),
        (b"B\xff\xff\xff\x7f.", "it is not a pickle"),
        (b"\x80\x04\x8e\xff\xff\xff\xff\xff\xff\xff\x7f.", "it is not a pickle"),
        (b"I" + b"9" * 100_000 + b"\n.", "it is not a pickle"),
        (b"cos\nsystem\n(S'true'\ntR.", "not tensors by name but 'os.system'"),
        (b"ccollections\nOrderedDict\n.", "not tensors by name but 'type'"),
        (b"(lp0\nh\x00.", "not tensors by name but 'list'"),
        (b"}K\x01K\x02s.", "not tensors by name"),
        (b"}(U\x01aNu.", "^a is not an array of finite numbers but 'NoneType'"),
    ],
)
def test_a_pickle_that_does_too_much_is_refused(pickled: bytes, message: str) -> None:
    content = repacked(saved({"a": torch.zeros(2)}), lambda name, part: pickled if "data.pkl" in name else part)
    refused(content, message)


@pytest.mark.parametrize(
    ("before", "after"),
    [(b"K\x02\x85", b"K\x03\x85"), (b"K\x02\x85", b"J\xfe\xff\xff\xff\x85"), (b"K\x01\x85", b"G?\xf0\0\0\0\0\0\0\x85")],
)
def test_a_shape_that_its_numbers_do_not_have_is_refused(before: bytes, after: bytes) -> None:
    def change(name: str, part: bytes) -> bytes:
        return part.replace(before, after) if "data.pkl" in name else part

    refused(repacked(saved({"bad": torch.zeros(2)}), change), "^bad has ")


def test_whatever_byte_is_damaged_it_is_read_or_refused() -> None:
    tensors = {"a": torch.arange(6.0).reshape(2, 3), "b": torch.arange(2.0)}
    whole = repacked(saved(tensors), lambda name, part: part, zipfile.ZIP_DEFLATED)
    rng = np.random.default_rng(3)
    refusals = 0
    for at in range(len(whole)):
        damaged = bytearray(whole)
        damaged[at] ^= 1 << rng.integers(8)
        try:
            found = read_tensors(bytes(damaged), MIB)
        except ValueError:
            refusals += 1
        else:
            assert all(np.isfinite(array).all() for array in found.values())
    assert refusals > len(whole) // 10


def test_a_zip_of_very_many_parts_is_refused() -> None:
    refused(b"PK\x01\x02" * 10_001, "more than 10,000 parts")


def test_damaged_compression_is_refused() -> None:
    content = repacked(saved({"a": torch.arange(100.0)}), lambda name, part: part, zipfile.ZIP_DEFLATED)
    start = content.index(b"archive/data/0") + len("archive/data/0")
    with pytest.raises(zlib.error):
        zlib.decompress(b"\xff" * 50, -15)
    refused(content[:start] + b"\xff" * 50 + content[start + 50 :], "not a .zip that can be read: Error -3")
