"""Planners by name."""

from typing import Any

from ppaas.planners.base import Planner
from ppaas.plugins import PluginRegistry

PLANNERS: PluginRegistry[Planner] = PluginRegistry(
    "ppaas.planners",
    "planner",
    Planner,  # type: ignore[type-abstract]
    aliases={
        "global_planner/GlobalPlanner": "dijkstra",
        "nav2_smac_planner/SmacPlanner2D": "astar",
        "nav2_smac_planner/SmacPlannerHybrid": "lattice",
        "nav2_theta_star_planner/ThetaStarPlanner": "theta_star",
        "navfn/NavfnROS": "navfn",
        "nav2_navfn_planner/NavfnPlanner": "navfn",
    },
)


def create(name: str, **parameters: Any) -> Planner:
    """Make a planner by its name or its ROS alias.

    Raises
    ------
    NotFound
        No planner of that name is installed.
    InvalidParameter
        It takes no such parameter.
    """
    return PLANNERS.create(name, parameters)


def planner_names() -> tuple[str, ...]:
    """Return the names of all planners installed."""
    return PLANNERS.names()
