"""Robot to export: its file, its body, its map, and all parameters that its clone has in use."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from ppaas.clone.assembly import build_clone
from ppaas.clone.robot_body import robot_body
from ppaas.controllers.registry import CONTROLLERS
from ppaas.costmap.map_layers import empty_layers
from ppaas.errors import InvalidParameter
from ppaas.maps.grid import GridMap
from ppaas.maps.new_map import new_map_id
from ppaas.nodes.graph import Graph
from ppaas.planners.registry import PLANNERS
from ppaas.robot_model.describe import describe
from ppaas.robot_model.known_models import RobotModel
from ppaas.zones.zone import NO_ZONES, ZoneSet

T = TypeVar("T")

Tables = Mapping[str, Mapping[str, Any]]
"""Parameters by the name of their node or plug-in."""


@dataclass(frozen=True)
class MapToExport:
    """Map of a robot.

    Parameters
    ----------
    id : str
    grid : GridMap
    zones : ZoneSet
    masks : dict of str to GridMap
        Maps of the costmap filters of the robot, by the names of the filters.
    has_octomap : bool
        Whether the map has an octomap, of which the clone keeps off what is at the robot's height.
    """

    id: str
    grid: GridMap
    zones: ZoneSet = NO_ZONES
    masks: Mapping[str, GridMap] = field(default_factory=dict)
    has_octomap: bool = False


@dataclass(frozen=True)
class RobotToExport:
    """A robot.

    Parameters
    ----------
    name : str
        Id of the robot.
    file : dict
        Its robot file, decoded from JSON.
    body : RobotModel
    in_use : dict of dict
        All parameters of its clone, with defaults.
    map : MapToExport or None
        Its map; None if it makes one.
    urdf : bytes, optional
        Its URDF.
    """

    name: str
    file: Mapping[str, Any]
    body: RobotModel
    in_use: Tables
    map: MapToExport | None = None
    urdf: bytes | None = None

    @property
    def given(self) -> Tables:
        """Parameters of the robot file, by the own names of plug-ins."""
        tables: dict[str, dict[str, Any]] = {}
        for section, table in self.file.get("parameters", {}).items():
            name = PLANNERS.own_name(CONTROLLERS.own_name(section))
            tables[name] = {**tables.get(name, {}), **(table if isinstance(table, dict) else {})}
        return tables

    def is_given(self, section: str, name: str) -> bool:
        """Return whether the robot file sets a parameter."""
        return name in self.given.get(section, {})

    @property
    def planner(self) -> str:
        """Own name of its global planner."""
        return PLANNERS.own_name(str(self.in_use["move_base"]["base_global_planner"]))

    @property
    def controller(self) -> str:
        """Own name of its local planner."""
        return CONTROLLERS.own_name(str(self.in_use["move_base"]["base_local_planner"]))


def robot_to_export(
    name: str, file: Mapping[str, Any], map_: MapToExport | None = None, urdf: bytes | None = None
) -> RobotToExport:
    """Return a robot with all parameters that its clone has in use.

    Parameters
    ----------
    name : str
        Id of the robot.
    file : mapping
        Its robot file, decoded from JSON.
    map_ : MapToExport, optional
        Its map; None if it makes one.
    urdf : bytes, optional
        Its URDF.

    Raises
    ------
    InvalidParameter
        The clone refuses the file, or the map is missing.
    NotFound
        A plug-in is not installed here.
    InvalidUrdf
        The URDF cannot be read.
    """
    makes_map = new_map_id(file["map"]) is not None
    if not makes_map and map_ is None:
        raise InvalidParameter(f"the robot needs its map {file['map']!r}")
    described = None if urdf is None else describe(urdf)
    parameters = {key: table for key, table in file.get("parameters", {}).items() if key not in OF_MACHINES}
    in_use = build_clone(
        Graph(_no_work),
        None if makes_map or map_ is None else empty_layers(map_.grid.info.resolution),
        model=file.get("model", "turtlebot2"),
        urdf=described,
        initial_pose=tuple(file.get("initial_pose", (0.0, 0.0, 0.0))),
        base_global_planner=file.get("base_global_planner", "dijkstra"),
        base_local_planner=file.get("base_local_planner", "dwa"),
        parameters=parameters,
        only=(),
    )
    body = robot_body(file.get("model", "turtlebot2"), described, parameters)
    return RobotToExport(name, file, body, in_use, map_, urdf)


OF_MACHINES = frozenset({"recorder", "node_monitor"})
"""Parameters in a robot file that are for the machine of its clone, and for no node that drives."""


def _no_work(work: Callable[[Callable[[], bool]], T], cancelled: object, done: object) -> None:
    """Run no job: a clone that is only built plans nothing."""
