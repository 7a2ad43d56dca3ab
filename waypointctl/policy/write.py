"""Writing a policy bundle."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from waypointctl.errors import OutputError
from waypointctl.policy.bundle import LoadedPolicy, load_policy_bytes
from waypointctl.policy.manifest import MANIFEST, NETWORK, WEIGHTS, Manifest, PolicyDescription

_LAST: Final = MANIFEST  # until it is replaced, the new files fail its hashes


def bundle_files(description: PolicyDescription, onnx: bytes, safetensors: bytes) -> dict[str, bytes]:
    """Return the files of a bundle by name, for `load_policy_bytes` or a folder."""
    contents = {NETWORK: onnx, WEIGHTS: safetensors}
    manifest = Manifest.model_validate(
        {
            **{field: getattr(description, field) for field in PolicyDescription.model_fields},
            "files": {name: _record(content) for name, content in contents.items()},
        }
    )
    return contents | {MANIFEST: f"{manifest.model_dump_json(indent=2)}\n".encode()}


def write_bundle(folder: Path, description: PolicyDescription, onnx: bytes, safetensors: bytes) -> LoadedPolicy:
    """Write a bundle and return it, loaded.

    The files are written into a hidden folder and moved into place when they are complete. A folder that does not
    exist appears whole. In one that does, files of other names stay, and the bundle's are replaced one by one,
    manifest.json last: a reader gets the old bundle, the new one, or a refusal because of the hashes.

    Args:
        folder: where the bundle goes.
        description: all of the manifest but the files.
        onnx: the normaliser and the network, from observation (n, k) to action (n, nu), float32.
        safetensors: the weights and the normaliser's statistics, for going on with training.

    Raises:
        PolicyError: the network does not fit the description; nothing is written.
        OutputError: the folder cannot be written.
    """
    policy = load_policy_bytes(bundle_files(description, onnx, safetensors), str(folder))
    copy_bundle(policy, folder)
    return policy


def copy_bundle(policy: LoadedPolicy, folder: Path) -> None:
    """Write a policy's files into `folder`, in the way and with the errors of `write_bundle`."""
    # In a folder that is there, which can be another file system than the one around it, such as a container's volume.
    parent = folder if folder.is_dir() else folder.parent
    staging = parent / f".{folder.name}.{os.getpid()}.tmp"
    try:
        staging.mkdir(parents=True)
        _put(folder, staging, policy.files)
    except OSError as error:
        problem = f"the policy cannot be written: {error.strerror}"
        raise OutputError(problem, where=str(folder), hint="use a folder that you can write to") from error
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _record(content: bytes) -> dict[str, str | int]:
    return {"sha256": hashlib.sha256(content).hexdigest(), "size": len(content)}


def _put(folder: Path, staging: Path, files: Mapping[str, bytes]) -> None:
    for name, content in files.items():
        (staging / name).write_bytes(content)
    if not folder.exists():
        staging.rename(folder)
        return
    for name in sorted(files, key=lambda name: name == _LAST):
        (staging / name).replace(folder / name)
