"""Registry of planners by name and ROS alias."""

from typing import TYPE_CHECKING, Any, Literal, overload

from ppaas.planners.base import Planner
from ppaas.plugins import PluginRegistry

if TYPE_CHECKING:
    from ppaas.planners.base3d import VolumePlanner

PLANNERS: PluginRegistry[Planner] = PluginRegistry(
    "ppaas.planners",
    "planner",
    Planner,  # type: ignore[type-abstract]
    aliases={
        "global_planner/GlobalPlanner": "dijkstra",
        "nav2_smac_planner/SmacPlanner2D": "astar",
        "nav2_smac_planner/SmacPlannerHybrid": "lattice",
        "nav2_smac_planner/SmacPlannerLattice": "lattice",
        "nav2_theta_star_planner/ThetaStarPlanner": "theta_star",
        "navfn/NavfnROS": "navfn",
        "nav2_navfn_planner/NavfnPlanner": "navfn",
    },
)


@overload
def create(name: Literal["astar3d", "dijkstra3d"], **parameters: Any) -> "VolumePlanner": ...
@overload
def create(name: str, **parameters: Any) -> Planner: ...
def create(name: str, **parameters: Any) -> "Planner | VolumePlanner":
    """Create a planner by its name or ROS alias. Planners in space take another kind of map and request.

    Raises
    ------
    NotFound
        No planner of that name is installed.
    InvalidParameter
        The planner has no such parameter, or the value is invalid.
    """
    if PLANNERS.own_name(name) not in PLANNERS.names():
        from ppaas.planners.base3d import VOLUME_PLANNERS  # noqa: PLC0415 - heavy, and few robots fly

        if name in VOLUME_PLANNERS.names():
            return VOLUME_PLANNERS.create(name, parameters)
    return PLANNERS.create(name, parameters)


def planner_names() -> tuple[str, ...]:
    """Return the names of all installed planners in the plane."""
    return PLANNERS.names()
