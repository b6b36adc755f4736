"""Localization of a clone: by AMCL on a published map, or by ``grid_slam`` on the map that it makes."""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ppaas import mapping
from ppaas.clone.node_parameters import NodeParameters
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.maps.grid import UNKNOWN, GridInfo, GridMap
from ppaas.nodes.amcl.node import AmclNode
from ppaas.nodes.base import Context, Node
from ppaas.nodes.frames import FrameNames
from ppaas.nodes.map_server.node import MapServerNode
from ppaas.thread_budget import Threads

if TYPE_CHECKING:
    from ppaas.nodes.grid_slam.parameters import GridSlamParameters

GRID_SLAM = "grid_slam"
"""Node that makes a map."""

BLANK = 64
"""Edge of the blank map with which a robot starts to make one [cells]."""

Makers = dict[str, Callable[[Context], Node]]


@dataclass(frozen=True, slots=True)
class Localization:
    """Map and localization of a clone.

    Parameters
    ----------
    layers : MapLayers
        The map at the start.
    names : FrameNames
        Names of the robot's frames.
    makers : dict of str to callable
        Makers of the nodes, by name.
    by_robot : bool
        Whether the robot localizes itself.
    """

    layers: MapLayers
    names: FrameNames
    makers: Makers
    by_robot: bool = False


def on_map(
    given: NodeParameters, layers: MapLayers, initial_pose: tuple[float, float, float], threads: Threads
) -> Localization:
    """Return the map server and AMCL. Parameters of ``grid_slam`` are checked, but not used.

    Raises
    ------
    InvalidParameter
        A parameter is unknown or invalid.
    """
    amcl = given.read(AmclParameters, AmclNode.name)
    if given.has(GRID_SLAM):
        given.check(_grid_slam_parameters(), GRID_SLAM)
    names = FrameNames.of(amcl.odom_frame_id, amcl.base_frame_id, amcl.global_frame_id, amcl.tf_prefix)
    makers: Makers = {
        MapServerNode.name: lambda context: MapServerNode(context, layers),
        AmclNode.name: lambda context: AmclNode(context, layers, Pose2D(*initial_pose), amcl, threads, names=names),
    }
    return Localization(layers, names, makers, by_robot=not amcl.localize)


def while_mapping(given: NodeParameters, posegraph: Callable[[str], bytes | memoryview] | None = None) -> Localization:
    """Return ``grid_slam`` with a blank map. Parameters of ``amcl`` are checked, but not used.

    Parameters
    ----------
    given : NodeParameters
    posegraph : callable, optional
        Returns the file of the pose graph of the map that ``map_file_name`` names.

    Raises
    ------
    InvalidParameter
        A parameter is unknown or invalid.
    """
    # Imported only here, so that not every container loads its kernels.
    from ppaas.nodes.grid_slam.node import GridSlamNode  # noqa: PLC0415
    from ppaas.nodes.grid_slam.posegraph_services import PoseGraphStore  # noqa: PLC0415

    parameters = given.read(_grid_slam_parameters(), GRID_SLAM)
    given.check(AmclParameters, AmclNode.name)
    blank = blank_layers(parameters.drawing().resolution)
    graphs = PoseGraphStore(load=None if posegraph is None else only(parameters.map_file_name, posegraph))
    makers: Makers = {
        GRID_SLAM: lambda context: GridSlamNode(
            context, parameters, prepare=_load_tracking, graphs=graphs, prepare_closures=_load_kernels
        )
    }
    return Localization(blank, parameters.frames(), makers)


def only(name: str, posegraph: Callable[[str], bytes | memoryview]) -> Callable[[str], bytes | memoryview]:
    """Return the loader of pose graphs of a clone, which has only one map's graph.

    The loader raises ``Unavailable`` for other names.
    """

    def load(requested: str) -> bytes | memoryview:
        if requested != name:
            raise Unavailable(
                f"pose graph {requested!r} is not loaded here, but that of map {name!r}: to use another, change "
                "map_file_name in the robot's parameters"
            )
        return posegraph(requested)

    return load


def _grid_slam_parameters() -> "type[GridSlamParameters]":
    from ppaas.nodes.grid_slam.parameters import GridSlamParameters  # noqa: PLC0415  # as above

    return GridSlamParameters


def _load_tracking() -> None:
    """Load the kernels that scans and the drawing of a map need."""
    _load_kernels("kernels.")


def _load_kernels(of: str = "") -> None:
    """Load the kernels of mapping, which are not loaded with those that all clones use.

    Parameters
    ----------
    of : str
        Beginning of the names of their modules.
    """
    begin = f"{mapping.__name__}.{of}"
    for module in [module for name, module in sorted(sys.modules.items()) if name.startswith(begin)]:
        if hasattr(module, "warm"):
            module.warm()


@lru_cache(maxsize=4)  # the check of a robot file builds its clone again and again
def blank_layers(resolution: float) -> MapLayers:
    """Return the layers of a map that is all unknown, around the origin of the map frame; cells in [m]."""
    corner = -0.5 * BLANK * resolution
    info = GridInfo(resolution, BLANK, BLANK, Pose2D(corner, corner))
    return build_layers(GridMap(np.full(info.shape, UNKNOWN, np.int8), info))


def localizes_itself(parameters: Mapping[str, Any]) -> bool:
    """Return whether the parameters of a robot's nodes say that it localizes itself; invalid ones do not."""
    amcl = parameters.get(AmclNode.name)
    return isinstance(amcl, Mapping) and amcl.get("localize") is False
