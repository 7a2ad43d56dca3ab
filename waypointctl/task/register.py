"""The environment under its name in Gymnasium's registry.

    import gymnasium
    env = gymnasium.make("waypointctl.task.register:waypointctl/Waypoint-v0")

imports this module, which registers the name, and makes the environment. Gymnasium read entry points of the group
"gymnasium.envs" until 0.29; programs that still do find `register` there.
"""

from __future__ import annotations

from typing import Final

ENV_ID: Final = "waypointctl/Waypoint-v0"


def register() -> None:
    """Register the environment under its name; a second call has no effect.

    Raises:
        ModuleNotFoundError: gymnasium is not installed.
    """
    try:
        import gymnasium
    except ModuleNotFoundError as error:
        problem = f"{ENV_ID} needs gymnasium, which is not installed: pip install 'waypointctl[train]'"
        raise ModuleNotFoundError(problem, name=error.name) from error
    if ENV_ID not in gymnasium.registry:
        gymnasium.register(ENV_ID, entry_point="waypointctl.task.env:WaypointEnv")


register()  # on import, as Gymnasium's "module:name" requires
