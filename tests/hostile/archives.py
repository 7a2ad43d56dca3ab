"""Hostile models of stable-baselines3 and files of VecNormalize, from a seed."""

from __future__ import annotations

import io
import json
import os
import pickle
import random
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import torch

from tests.hostile.bundles import ANY, REFUSED, Attempt, Family, Sound
from tests.hostile.mutation import NASTY, damaged, of_another_kind, reworded

LARGE: Final = (bytes(2**29), b"[" * 10_000_000, b"]r\xff\xff\xff\x7f.", b'{"a":' * 100_000, b"[]," * 6_000_000)
OTHER_TENSORS: Final[dict[str, Callable[[], Any]]] = {
    "fp8": lambda: torch.zeros(8, 8).to(torch.float8_e4m3fn),
    "bfloat16": lambda: torch.zeros(8, 8).bfloat16(),
    "meta": lambda: torch.zeros(8, 8, device="meta"),
    "sparse": lambda: torch.zeros(8, 8).to_sparse(),
    "complex": lambda: torch.zeros(8, 8, dtype=torch.complex64),
    "int8": lambda: torch.zeros(8, 8, dtype=torch.int8),
    "repeated": lambda: torch.zeros(1).expand(2**30),
    "nan": lambda: torch.full((8, 8), torch.nan),
    "wide": lambda: torch.zeros(2**20, 1),
    "none": lambda: None,
    "object": lambda: Path("/"),
}


def _saved(tensors: Any) -> bytes:
    buffer = io.BytesIO()
    torch.save(tensors, buffer)
    return buffer.getvalue()


def _parts(content: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def _packed(parts: dict[str, bytes], compression: int = zipfile.ZIP_STORED) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", compression) as archive:
        for name, content in parts.items():
            archive.writestr(name, content)
    return buffer.getvalue()


def _attempt(name: str, folder: Path, model: bytes, may: frozenset[int] = ANY, *, normaliser: bool = False) -> Attempt:
    if not os.path.lexists(folder / "model.zip"):
        (folder / "model.zip").write_bytes(model)
    more = ("--vecnormalize", "normaliser.pkl") if normaliser else ()
    arguments = ("policies", "import", "model.zip", "--out", "imported", "--observation", "egocentric", *more)
    return Attempt(name, arguments, folder, may)


def damaged_archive(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    model = _packed(_parts(sound.more["model"]), rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)))
    return _attempt("archive: damaged", folder, damaged(rng, model))


def other_settings(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    parts = _parts(sound.more["model"])
    parts["data"] = json.dumps(reworded(rng, json.loads(parts["data"]))).encode()
    return _attempt("archive: data reworded", folder, _packed(parts))


def other_tensor(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    parts = _parts(sound.more["model"])
    tensors = torch.load(io.BytesIO(parts["policy.pth"]), weights_only=True)
    name, kind = rng.choice(sorted(tensors)), rng.choice(sorted(OTHER_TENSORS))
    parts["policy.pth"] = _saved(tensors | {name: OTHER_TENSORS[kind]()})
    return _attempt(f"archive: {kind} tensor", folder, _packed(parts), frozenset({REFUSED}))


def damaged_tensors(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    parts = _parts(sound.more["model"])
    inner = _parts(parts["policy.pth"])
    name = rng.choice([name for name in inner if name.endswith("data.pkl")] * 3 + sorted(inner))
    inner[name] = damaged(rng, inner[name])
    parts["policy.pth"] = _packed(inner)
    return _attempt(f"archive: policy.pth/{name} damaged", folder, _packed(parts))


def bomb(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    """A small archive of what is large: a part of a GiB, nested lists, a table of a pickle."""
    parts = _parts(sound.more["model"])
    name = rng.choice(("data", "policy.pth", "_stable_baselines3_version"))
    large = rng.choice(LARGE)
    if name == "policy.pth" and rng.random() < 0.5:
        inner = _parts(parts[name])
        part = rng.choice(("data.pkl", "/data/0"))
        inner[next(each for each in inner if each.endswith(part))] = large
        large = _packed(inner, zipfile.ZIP_DEFLATED)
    parts[name] = large
    return _attempt(f"archive: {name} is a bomb", folder, _packed(parts, zipfile.ZIP_DEFLATED))


def other_kind(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    kind = of_another_kind(rng, folder / "model.zip")
    return _attempt(f"archive: {kind}", folder, b"", frozenset({REFUSED}))


def other_normaliser(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    path, name = folder / "normaliser.pkl", "normaliser: damaged"
    match rng.randrange(4):
        case 0:
            name = f"normaliser: {of_another_kind(rng, path)}"
        case 1:
            path.write_bytes(pickle.dumps(rng.choice(NASTY)))
        case _:
            path.write_bytes(damaged(rng, sound.more["normaliser"]))
    return _attempt(name, folder, sound.more["model"], normaliser=True)


ARCHIVES: Final[tuple[Family, ...]] = (
    damaged_archive,
    other_settings,
    other_tensor,
    damaged_tensors,
    bomb,
    other_kind,
    other_normaliser,
)
