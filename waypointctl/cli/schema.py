"""`waypointctl schema`: the JSON Schema of a file that people write, for their editors."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Annotated, Any, Final

import typer

from waypointctl.errors import InputError


def _mission() -> dict[str, Any]:
    from waypointctl.mission.files import mission_schema

    return mission_schema()


def _recipe() -> dict[str, Any]:
    from waypointctl.training.recipe_file import recipe_schema

    return recipe_schema()


def _suite() -> dict[str, Any]:
    from waypointctl.evaluation.suite import suite_schema

    return suite_schema()


_SCHEMAS: Final[dict[str, Callable[[], dict[str, Any]]]] = {"mission": _mission, "recipe": _recipe, "suite": _suite}


def schema(of: Annotated[str, typer.Argument(metavar="|".join(_SCHEMAS), help="The kind of file.")]) -> None:
    """Print a JSON Schema, for editors.

    An editor with the schema completes keys and marks errors as you type.
    """
    if of not in _SCHEMAS:
        raise InputError(f"unknown schema {of!r}", hint=f"choose one of: {', '.join(_SCHEMAS)}")
    typer.echo(json.dumps(_SCHEMAS[of](), indent=2, allow_nan=False))
