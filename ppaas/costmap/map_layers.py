"""Layers of a map, derived once per map version and robot radius and shared by all containers of a machine."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.causes import Causes
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.zones.zone import NO_ZONES, ZoneSet


@dataclass(frozen=True, slots=True)
class MapLayers:
    """Map and its layers. The arrays are read-only, and memory-mapped where the containers of a machine share them.

    Parameters
    ----------
    grid : GridMap
        The map itself.
    costmap : Costmap
        Static layer, inflated for the robot's radius; keep-out zones count as occupied.
    distance : (height, width) float32 array
        Distance from each cell to the nearest occupied cell [m]; AMCL's likelihood field is computed from it.
    keepout : GridMap, optional
        Keep-out mask in the cells of the map: 100 is forbidden, 1 to 99 are avoided the more the higher they are.
    barred_distance : (height, width) float32 array, optional
        With ``keepout`` or another lethal threshold: distance to the nearest cell that is lethal for this robot or 100
        in ``keepout`` [m].
    overhead : GridMap, optional
        Part of ``keepout`` that is an octomap at the heights of the robot, in the cells of the map: 100 is occupied.
    speed : GridMap, optional
        Mask of the speed filter, in the cells of the map.
    zones : ZoneSet
        Zones of the map. Keep-out zones without times are part of ``keepout``.
    """

    grid: GridMap
    costmap: Costmap
    distance: NDArray[np.float32]
    keepout: GridMap | None = None
    barred_distance: NDArray[np.float32] | None = None
    speed: GridMap | None = None
    zones: ZoneSet = NO_ZONES
    overhead: GridMap | None = None

    @property
    def to_lethal(self) -> NDArray[np.float32]:
        """(height, width) float32 array: distance to the nearest lethal or forbidden cell [m]."""
        return self.distance if self.barred_distance is None else self.barred_distance


def with_causes(layers: MapLayers) -> MapLayers:
    """Return layers whose costmap knows why a cell is lethal."""
    return replace(layers, costmap=replace(layers.costmap, causes=Causes(layers)))


def unchanged(layers: MapLayers) -> MapLayers:
    """Return layers as they are."""
    return layers


_EMPTY_EDGE = 64
"""Edge of an empty map [cells]."""


def empty_layers(resolution: float) -> MapLayers:
    """Return the layers of a map without obstacles, whose cells have an edge of ``resolution`` [m]."""
    info = GridInfo(resolution, _EMPTY_EDGE, _EMPTY_EDGE, Pose2D(0.0, 0.0))
    free = GridMap(np.zeros(info.shape, np.int8), info)
    far = np.full(info.shape, _EMPTY_EDGE * resolution, np.float32)
    costs = Costmap(np.zeros(info.shape, np.uint8), info)
    return MapLayers(free, costs, far, keepout=free, barred_distance=far, speed=free)
