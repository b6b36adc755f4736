"""Way out for a robot that a keep-out zone or mask came over.

While a part of the robot is in it, the cells of it are expensive instead of lethal, so that the robot leaves. Other
zones stay lethal. Once it has left, so is this one, and the robot is not led in again.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.causes import kept_out_zones
from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED, GridInfo, GridMap
from ppaas.polygons import Points, within_polygon
from ppaas.zones.masks import touched_window
from ppaas.zones.zone import KeepOut, Zone

EXPENSIVE = 99
"""Value of a keep-out mask in a zone that a robot leaves: a cost of 251, the highest that is not a collision."""


class Leaving:
    """Zones and masks that a robot is in.

    Parameters
    ----------
    layers : MapLayers
        Layers of the map.
    radius : float
        Radius of the robot [m].
    hull : (n, 2) array, optional
        Convex outline of the robot in its own frame, instead of the disc [m].

    Attributes
    ----------
    map_layers : MapLayers
        Layers of the map.
    layers : MapLayers
        Layers by which the robot drives now: the map's layers, or the layers by which it leaves.
    """

    def __init__(self, layers: MapLayers, radius: float, hull: Points | None = None) -> None:
        self.map_layers = self.layers = layers
        self._hull = hull
        self._reach = radius if hull is None else float(np.hypot(*hull.T).max())

    @property
    def active(self) -> bool:
        """Whether the robot leaves a zone."""
        return self.layers is not self.map_layers

    def use_layers(self, layers: MapLayers) -> None:
        """Replace the map."""
        self.map_layers = self.layers = layers

    def look(self, pose: Pose2D) -> bool:
        """Take the pose of the robot in the frame of the map; return whether `layers` are others than before."""
        before = self.layers
        inside = self._barred_cells(pose)
        if not len(inside):
            self.layers = self.map_layers
        elif not self.active or not self._opens(inside):
            self.layers = opened(self.map_layers, self.map_layers.grid.info.to_world(inside).reshape(-1, 2))
        return self.layers is not before

    def _opens(self, cells: NDArray[np.int64]) -> bool:
        """Return whether the layers in use bar none of some cells."""
        assert self.layers.keepout is not None
        return bool((self.layers.keepout.data[tuple(cells.T)] < OCCUPIED).all())

    def _barred_cells(self, pose: Pose2D) -> NDArray[np.int64]:
        """Return the (n, 2) barred cells that the robot is in; of a disc, those around it count once it leaves."""
        none = np.empty((0, 2), np.int64)
        info, keepout = self.map_layers.grid.info, self.map_layers.keepout
        if keepout is None:
            return none
        here = info.origin.inverse() @ pose
        row, column = here.y / info.resolution - 0.5, here.x / info.resolution - 0.5
        reach = self._reach / info.resolution
        top, left = (max(int(np.floor(index - reach)), 0) for index in (row, column))
        window = keepout.data[top : max(int(row + reach) + 2, 0), left : max(int(column + reach) + 2, 0)]
        cells = np.argwhere(window == OCCUPIED) + np.array((top, left))
        offsets = cells - (row, column)
        if self._hull is not None:
            near = _within_hull(self._hull, offsets[:, ::-1] * info.resolution, here.theta)
        else:
            near = np.hypot(*offsets.T) < (reach if self.active else max(1.0, reach / 2.0))
        found: NDArray[np.int64] = cells[near]
        return found


def _within_hull(hull: Points, offsets: Points, theta: float) -> NDArray[np.bool_]:
    c, s = np.cos(theta), np.sin(theta)
    return within_polygon(hull, offsets @ np.array(((c, -s), (s, c))))


def opened(layers: MapLayers, inside: NDArray[np.float64]) -> MapLayers:
    """Return layers in which the zones of some barred cells are expensive instead of lethal.

    If no zone bars them, a mask does; then all that only masks bar is opened. The costmap is the earlier one, by which
    robots plan as soon as they have left.

    Parameters
    ----------
    layers : MapLayers
        With a keep-out mask.
    inside : (n, 2) float array
        Centres of barred cells, in the frame of the map [m].
    """
    assert layers.keepout is not None
    info, barred = layers.grid.info, layers.keepout.data == OCCUPIED
    left = list(kept_out_zones(layers, inside))
    others = [zone for zone in layers.zones.zones if isinstance(zone.rule, KeepOut) and zone not in left]
    opens = _touched(info, left)
    rows, columns = info.to_cells(inside).T
    if not opens[rows, columns].all():
        opens = barred
    opens &= barred & ~_touched(info, [zone for zone in others if not zone.rule.times])
    keepout = np.where(opens, np.int8(EXPENSIVE), layers.keepout.data)
    if layers.barred_distance is not None:  # cells of the map that are lethal by another threshold stay lethal
        keepout[(layers.barred_distance == 0.0) & ~barred] = OCCUPIED
    return replace(layers, keepout=GridMap(keepout, info), barred_distance=None)


def _touched(info: GridInfo, zones: list[Zone]) -> NDArray[np.bool_]:
    mask = np.zeros(info.shape, np.bool_)
    for zone in zones:
        window, touched = touched_window(info, zone.area)
        mask[window] |= touched
    return mask
