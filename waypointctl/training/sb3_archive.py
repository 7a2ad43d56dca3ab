"""Reading a model that stable-baselines3 saved, without executing any of it.

Its .zip holds the networks (policy.pth, tensors that torch reads with weights_only) and the settings (data, JSON).
What JSON cannot hold is pickled in there, base64 under ":serialized:", with a readable description beside it
(stable_baselines3/common/save_util.py). Here the descriptions are read and the pickles are left alone.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, cast

import torch

from waypointctl.errors import PolicyError

LARGEST: Final = 512 * 2**20  # [bytes] of a file, and of what a part of it unpacks to

_DATA: Final = "data"
_TENSORS: Final = "policy.pth"
_VERSION: Final = "_stable_baselines3_version"
_MEND: Final = "Give the .zip that stable-baselines3's model.save() wrote."


@dataclass(frozen=True, slots=True)
class Sb3Archive:
    """A saved model.

    Attributes:
        path: of the .zip.
        sha256: of its bytes.
        version: of the stable-baselines3 that wrote it.
        settings: of the algorithm, by name; what was pickled is its readable description.
        tensors: of the networks, by name, on the CPU.
    """

    path: Path
    sha256: str
    version: str
    settings: Mapping[str, Any]
    tensors: Mapping[str, torch.Tensor]

    @property
    def policy_class(self) -> str:
        """The policy's class, "module.Name"; as much of it as can be told."""
        described = self.described("policy_class")
        module = described.get("__module__") or "unknown"
        made = re.search(r"<function ([\w.]+)\.__init__ ", str(described.get("__init__")))
        return f"{module}.{made[1]}" if made else str(module)

    @property
    def policy_kwargs(self) -> Mapping[str, Any]:
        """What was given to the policy, classes as text such as "<class 'torch.nn.modules.activation.ReLU'>"."""
        return {name: value for name, value in self.described("policy_kwargs").items() if not name.startswith(":")}

    def described(self, name: str) -> Mapping[str, Any]:
        """Return a setting that is an object or a dict, by its items; empty if it is neither."""
        value = self.settings.get(name)
        return value if isinstance(value, dict) else {}

    def count(self, name: str) -> int:
        """Return a setting that is a whole number, 0 if it is none."""
        value = self.settings.get(name)
        return value if type(value) is int and value >= 0 else 0


def read_limited(path: Path) -> bytes:
    """Return a file's bytes.

    Raises:
        PolicyError: it cannot be read, or is larger than `LARGEST`.
    """
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except (OSError, ValueError) as error:
        problem = f"cannot be read: {getattr(error, 'strerror', None) or error}"
        raise PolicyError(problem, where=str(path)) from error
    if len(content) > LARGEST:
        raise PolicyError(f"larger than the {LARGEST >> 20} MiB that are read", where=str(path))
    return content


def read_archive(path: Path) -> Sb3Archive:
    """Read a saved model; nothing in it is executed.

    Raises:
        PolicyError: it cannot be read, is not such a .zip, or policy.pth holds more than tensors.
    """
    content = read_limited(path)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            parts = {name: _part(archive, name, str(path)) for name in (_DATA, _TENSORS)}
            version = _part(archive, _VERSION, str(path)) if _VERSION in archive.namelist() else b"unknown"
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, OSError, EOFError, ValueError) as error:
        raise PolicyError(f"not a .zip that can be read: {error}", where=str(path), mend=_MEND) from error
    return Sb3Archive(
        path,
        hashlib.sha256(content).hexdigest(),
        version.decode(errors="replace").strip()[:40] or "unknown",
        _settings(parts[_DATA], f"{path}/{_DATA}"),
        _tensors(parts[_TENSORS], f"{path}/{_TENSORS}"),
    )


def _part(archive: zipfile.ZipFile, name: str, where: str) -> bytes:
    if name not in archive.namelist():
        problem = f"no {name} in it; a model of stable-baselines3 has {_DATA} and {_TENSORS}"
        raise PolicyError(problem, where=where, mend=_MEND)
    # The size that the .zip declares is only a claim: read no more than the limit, whatever it says.
    with archive.open(name) as part:
        content = part.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise PolicyError(f"{name} unpacks to more than the {LARGEST >> 20} MiB that are read", where=where)
    return content


def _settings(content: bytes, where: str) -> dict[str, Any]:
    try:
        settings = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise PolicyError(f"not JSON: {error}", where=where, mend=_MEND) from error
    if not isinstance(settings, dict):
        raise PolicyError("not a JSON object", where=where, mend=_MEND)
    return settings


def _tensors(content: bytes, where: str) -> dict[str, torch.Tensor]:
    try:
        loaded = torch.load(io.BytesIO(content), map_location="cpu", weights_only=True)
    except Exception as error:  # torch and its pickle reader raise many kinds
        reason = next((line.strip() for line in str(error).splitlines() if "Unsupported" in line), "")
        problem = f"it is not tensors alone, and nothing of it was executed. {reason}".rstrip(". ")
        raise PolicyError(problem, where=where, mend=_MEND) from error
    if not isinstance(loaded, dict) or not all(
        isinstance(name, str) and isinstance(value, torch.Tensor) for name, value in loaded.items()
    ):
        raise PolicyError("not tensors by name", where=where, mend=_MEND)
    if fault := next((name for name, value in loaded.items() if not _finite(value)), None):
        raise PolicyError(f"{fault} is not an array of finite numbers", where=where, mend="The training diverged.")
    return cast("dict[str, torch.Tensor]", loaded)


def _finite(tensor: torch.Tensor) -> bool:
    return tensor.layout is torch.strided and tensor.is_floating_point() and bool(torch.isfinite(tensor).all())
