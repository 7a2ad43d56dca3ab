"""Reading manifest.json of a bundle."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from waypointctl.errors import InputError, PolicyError
from waypointctl.input_file import read_input
from waypointctl.mission.policy_name import known_folders
from waypointctl.policy.manifest import MANIFEST, SCHEMA_VERSION, Manifest

COPY_AGAIN: Final = "copy the whole folder again, or train the policy again"
LARGEST_MANIFEST: Final = 2**20  # [bytes]


def read_manifest(folder: Path) -> Manifest:
    """Read the manifest of the bundle in a folder, without the other files.

    Raises:
        PolicyError: it is missing or damaged.
    """
    content = read_input(folder / MANIFEST, LARGEST_MANIFEST, PolicyError, within=folder)
    return parse_manifest(content, f"{folder}/{MANIFEST}")


def other_policy_hint(robot: str) -> str:
    """Return, as a hint, how to find a policy for a robot."""
    for folder in known_folders():
        with suppress(InputError):  # a damaged one is not for any robot
            if read_manifest(folder).robot == robot:
                return f"choose a policy for {robot!r}: `waypointctl policies` lists them"
    return f"give the folder of a policy that was trained for {robot!r}"


def parse_manifest(text: bytes, where: str) -> Manifest:
    """Read a manifest from its bytes; `where` names it in messages.

    Raises:
        PolicyError: it is damaged, or of another schema version.
    """
    try:
        content: Any = json.loads(text, object_pairs_hook=_without_doubles)
    except (ValueError, RecursionError) as error:  # the latter: nested some thousand deep
        raise PolicyError(f"not JSON: {error}", where=where, hint=COPY_AGAIN) from error
    version = content.get("schema_version") if isinstance(content, dict) else None
    if type(version) is not int:
        problem = "not a policy's manifest: it must be an object with a whole number as schema_version"
        raise PolicyError(problem, where=where, hint=COPY_AGAIN)
    if version != SCHEMA_VERSION:
        problem = f"schema_version is {version}; this waypointctl reads {SCHEMA_VERSION}"
        raise PolicyError(problem, where=where, hint="use the waypointctl that wrote it, or train the policy again")
    try:
        return Manifest.model_validate_json(text)
    except ValidationError as error:
        raise PolicyError(_found(error), where=where, hint=COPY_AGAIN) from error


def _without_doubles(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a JSON object; a repeated key is refused, since readers differ in which one they use."""
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError(f"one of the keys {', '.join(found)[:200]} occurs twice")
    return found


def _found(error: ValidationError) -> str:
    lines = []
    for fault in error.errors(include_url=False):
        place = ".".join(str(part) for part in fault["loc"])
        lines.append(f"{place}: {fault['msg']}" if place else fault["msg"])
    return "; ".join(lines)
