"""What training needs besides waypointctl itself."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Final

from waypointctl.errors import InputError

MODULES: Final = ("torch", "stable_baselines3", "gymnasium", "onnx", "safetensors", "tensorboard")


def refuse_incomplete() -> None:
    """Refuse to train where a package of the extra `train` is missing.

    Raises:
        InputError: naming what is missing and how to install it.
    """
    if missing := [module for module in MODULES if find_spec(module) is None]:
        problem = f"training needs packages that are not installed: {', '.join(missing)}"
        raise InputError(problem, hint='Install them with the train extra: pip install ".[train]" in the checkout.')
