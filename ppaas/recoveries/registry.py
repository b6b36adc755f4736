"""Registry of recovery behaviours by name."""

from typing import Any

from ppaas.plugins import PluginRegistry
from ppaas.recoveries.base import Recovery

RECOVERIES: PluginRegistry[Recovery] = PluginRegistry(
    "ppaas.recoveries",
    "recovery behaviour",
    Recovery,  # type: ignore[type-abstract]
    aliases={
        "clear_costmap_recovery/ClearCostmapRecovery": "clear_costmap_recovery",
        "rotate_recovery/RotateRecovery": "rotate_recovery",
        "nav2_behaviors/Spin": "rotate_recovery",
        "nav2_behaviors::Spin": "rotate_recovery",
        "nav2_behaviors/BackUp": "back_up",
        "nav2_behaviors::BackUp": "back_up",
        "nav2_behaviors/Wait": "wait",
        "nav2_behaviors::Wait": "wait",
    },
)


def create(name: str, **parameters: Any) -> Recovery:
    """Return a new recovery behaviour by its name or its ROS alias.

    Raises
    ------
    NotFound
        No behaviour of that name is installed; the text lists those that are.
    InvalidParameter
        A parameter is unknown or invalid.
    """
    return RECOVERIES.create(name, parameters)


def recovery_names() -> tuple[str, ...]:
    """Return the names of all installed recovery behaviours."""
    return RECOVERIES.names()
