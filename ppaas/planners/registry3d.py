"""Registry of planners in space by name."""

from typing import Any

from ppaas.planners.base3d import VolumePlanner
from ppaas.plugins import PluginRegistry

VOLUME_PLANNERS: PluginRegistry[VolumePlanner] = PluginRegistry(
    "ppaas.planners3d",
    "planner in space",
    VolumePlanner,  # type: ignore[type-abstract]
    aliases={},
)


def create(name: str, **parameters: Any) -> VolumePlanner:
    """Create a planner in space by its name.

    Raises
    ------
    NotFound
        No planner of that name is installed.
    InvalidParameter
        The planner has no such parameter, or the value is invalid.
    """
    return VOLUME_PLANNERS.create(name, parameters)


def planner_names() -> tuple[str, ...]:
    """Return the names of all installed planners in space."""
    return VOLUME_PLANNERS.names()
