"""The algorithms that a recipe can name. One is added by its file here and its place in `Algorithm`."""

from __future__ import annotations

from typing import TypeAlias

from waypointctl.training.algorithms.ppo import PpoRecipe

# With a second one: Annotated[PpoRecipe | ..., Field(discriminator="name")].
Algorithm: TypeAlias = PpoRecipe
