"""Registry of local planners by name."""

from typing import Any

from ppaas.controllers.base import Controller
from ppaas.plugins import PluginRegistry

CONTROLLERS: PluginRegistry[Controller] = PluginRegistry(
    "ppaas.controllers",
    "controller",
    Controller,  # type: ignore[type-abstract]
    aliases={
        "dwa_local_planner/DWAPlannerROS": "dwa",
        "base_local_planner/TrajectoryPlannerROS": "dwa",
        "dwb_core/DWBLocalPlanner": "dwa",
        "nav2_mppi_controller/MPPIController": "mppi",
        "teb_local_planner/TebLocalPlannerROS": "mppi",
        "regulated_pure_pursuit": "pure_pursuit",
        "nav2_regulated_pure_pursuit_controller/RegulatedPurePursuitController": "pure_pursuit",
        "nav2_graceful_controller/GracefulController": "pure_pursuit",
        "vector_pursuit_controller/VectorPursuitController": "pure_pursuit",
    },
)


def create(name: str, **parameters: Any) -> Controller:
    """Return a new local planner by its name or its ROS alias.

    Raises
    ------
    NotFound
        No local planner of that name is installed.
    InvalidParameter
        A parameter is unknown or invalid.
    """
    return CONTROLLERS.create(name, parameters)


def controller_names() -> tuple[str, ...]:
    """Return the names of all installed local planners."""
    return CONTROLLERS.names()
