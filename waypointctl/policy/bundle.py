"""Reading a policy bundle: a folder of manifest.json, policy.onnx and weights.safetensors.

Nothing in a bundle is code, and nothing is used before its hash has been checked against the manifest's.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import PolicyError, given_number, given_path, wrong_type
from waypointctl.input_file import NOT_THERE, read_input
from waypointctl.mission.file_kind import FileKind, is_lfs_pointer
from waypointctl.mission.policy_name import policies_near, policies_there_are, policy_folder
from waypointctl.paths import folder_fault
from waypointctl.policy.manifest import MANIFEST, NETWORK, WEIGHTS, Manifest
from waypointctl.policy.manifest_file import COPY_AGAIN, LARGEST_MANIFEST, parse_manifest
from waypointctl.policy.protocol import Policy

if TYPE_CHECKING:
    from waypointctl.policy.network import Network

FILES: Final = (MANIFEST, NETWORK, WEIGHTS)
_FILE_LIMIT: Final = "policy-file"


@dataclass(frozen=True, slots=True)
class LoadedPolicy(Policy):
    """A network from a bundle, ready to act; it has no state."""

    manifest: Manifest
    files: Mapping[str, bytes]  # the whole bundle, by file name
    sha256: str  # of manifest.json, which has those of the other files
    network: Network

    @property
    def name(self) -> str:
        """Its name in the manifest."""
        return self.manifest.name

    @property
    def robot(self) -> str:
        """The robot it was trained for."""
        return self.manifest.robot

    @property
    def observation_layout(self) -> str | tuple[str, ...]:
        """The observation layout it was trained on: its name, or the names of its groups."""
        return self.manifest.observation_layout

    @property
    def reward_weights(self) -> Mapping[str, float]:
        """The weight of each reward term in its training."""
        return self.manifest.reward

    def act(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return actions of shape (n, nu), before clipping, for observations of shape (n, k).

        The network computes in float32. A row's action does not depend on the other rows.
        """
        return self.network.run(observation)

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what is pickled for another process: the files, which are loaded again there."""
        return load_policy_bytes, (self.files, self.name)


def load_policy(folder: Path | str, *, threads: int = 1) -> LoadedPolicy:
    """Read the bundle in a folder.

    Args:
        folder: with manifest.json, policy.onnx and weights.safetensors; a str is also the name of a policy in
            ./policies, or of one that comes with waypointctl.
        threads: how many share one call of the network; 1 is fastest for a batch of one.

    Raises:
        PolicyError: a file is missing, damaged or does not fit the manifest.
        InputError: an argument has a wrong type.
    """
    given = given_path("folder", folder, "a policy's folder, or its name")
    threads = given_number("threads", threads, 0, 1024)
    folder = policy_folder(folder) if isinstance(folder, str) else given
    if fault := folder_fault(folder):
        raise PolicyError(fault, where=str(folder), hint=policies_there_are(folder.name))
    files = {}
    for name in FILES:
        try:
            files[name] = _read(folder, name)
        except PolicyError as error:
            if error.problem != NOT_THERE:  # load_policy_bytes names the missing file
                raise
    if not files:
        raise PolicyError(_missing(FILES), where=str(folder), hint=policies_near(folder))
    return load_policy_bytes(files, str(folder), threads=threads)


def policy_of(policy: Policy | Path | str) -> Policy:
    """Return a policy that is given as itself, its folder, or its name.

    Raises:
        PolicyError: as for `load_policy`.
        InputError: it is none of these.
    """
    if isinstance(policy, Path | str):
        return load_policy(policy)
    if not callable(getattr(policy, "act", None)):  # any object of the protocol is one
        raise wrong_type("policy", policy, "a Policy, its folder, or its name")
    return policy


def load_policy_bytes(files: Mapping[str, bytes], where: str, *, threads: int = 1) -> LoadedPolicy:
    """Read a bundle from its files' bytes, by name, as a log's attachments give them.

    Args:
        files: the bundle; more files than its own are left out.
        where: the folder's or the log's name, for messages.
        threads: as for `load_policy`.

    Raises:
        PolicyError: a file is missing, damaged or does not fit the manifest.
    """
    from waypointctl.policy.network import Network  # with the audit of what it computes, which a manifest does not need

    own = {name: files[name] for name in FILES if name in files}
    if missing := [name for name in FILES if name not in own]:
        raise PolicyError(_missing(missing), where=where, hint=COPY_AGAIN)
    for name, content in own.items():
        if is_lfs_pointer(content):
            raise PolicyError(FileKind.LFS_POINTER.value, where=f"{where}/{name}")
    manifest = parse_manifest(own[MANIFEST], f"{where}/{MANIFEST}")
    _refuse_damaged(manifest, own, where)
    network = Network(own[NETWORK], f"{where}/{NETWORK}", threads)
    _refuse_other_sizes(manifest, network, where)
    return LoadedPolicy(manifest, own, hashlib.sha256(own[MANIFEST]).hexdigest(), network)


def _read(folder: Path, name: str) -> bytes:
    if name == MANIFEST:
        return read_input(folder / name, LARGEST_MANIFEST, PolicyError, within=folder)
    largest = max(_size(folder / each) for each in (NETWORK, WEIGHTS))
    return read_input(folder / name, _FILE_LIMIT, PolicyError, within=folder, enough=largest)


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


def _missing(names: Sequence[str]) -> str:
    return f"no {' and no '.join(names)}; a policy has {', '.join(FILES)}"


def _refuse_damaged(manifest: Manifest, files: Mapping[str, bytes], where: str) -> None:
    for name, expected in manifest.files.items():
        size = len(files[name])
        if size != expected.size:
            how = "truncated" if size < expected.size else "altered"
            problem = f"{how}: it has {size} bytes, its manifest has {expected.size}"
        elif hashlib.sha256(files[name]).hexdigest() != expected.sha256:
            problem = f"altered: its SHA-256 is not the manifest's {expected.sha256}"
        else:
            continue
        raise PolicyError(problem, where=f"{where}/{name}", hint=COPY_AGAIN)


def _refuse_other_sizes(manifest: Manifest, network: Network, where: str) -> None:
    sizes = (network.input_size, network.output_size)
    if sizes != (manifest.observation.size, manifest.action.size):
        problem = (
            f"the network maps {sizes[0]} numbers to {sizes[1]}, but the manifest has "
            f"{manifest.observation.size} observations and {manifest.action.size} actions"
        )
        raise PolicyError(problem, where=f"{where}/{NETWORK}", hint=COPY_AGAIN)
