"""Telling a laser that is covered, broken or switched off from one around which there is nothing."""

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.maps.layers import MapLayers
from ppaas.messages.sensor_msgs import LaserScan

MOST_RAYS = 36
"""Beams of a scan that are compared with the map, at most."""

IN_REACH, MARGIN = 0.9, 0.3
"""A wall that a laser should see is no farther than this part of its longest range, and farther than its shortest by
this [m]."""

SHOULD_SEE = 0.5
"""Part of its beams that should see one, from which on a laser that sees nothing is blind."""

BETWEEN = 1.5
"""What two cells take up of the distance between their middles [cells]; nearer to one, a ray goes on by half a cell."""


def check_sight(scan: LaserScan, layers: MapLayers, laser: Pose2D | None) -> None:
    """Refuse a scan of a laser that sees nothing, though it should: its robot would drive blind.

    That a beam has no reading tells nothing by itself: drivers say null, NaN, infinity or 0 where nothing is in reach.

    Parameters
    ----------
    scan : LaserScan
        Its angles are finite.
    layers : MapLayers
        The map.
    laser : Pose2D or None
        Where the laser is taken to be in the map, if that is known.

    Raises
    ------
    InvalidInput
        No beam has a reading, where the map has walls in sight of half of them.
    """
    ranges = scan.ranges
    if laser is None or not ranges:
        return
    if any(each is not None and scan.range_min <= each < scan.range_max for each in ranges):
        return
    chosen = np.linspace(0, len(ranges) - 1, min(MOST_RAYS, len(ranges))).round()
    away = _to_walls(layers, laser, laser.theta + scan.angle_min + scan.angle_increment * chosen, scan.range_max)
    in_sight = (away > scan.range_min + MARGIN) & (away < IN_REACH * scan.range_max)
    if np.mean(in_sight) >= SHOULD_SEE:
        raise InvalidInput(
            "no beam of a scan has a reading, and by the map half of them should: is the laser on, and the robot where "
            "it is taken to be?"
        )


def _to_walls(layers: MapLayers, laser: Pose2D, angles: NDArray[np.float64], most: float) -> NDArray[np.float64]:
    """Return how far each ray goes to an occupied cell of the map [m]: as far at a time as nothing is near."""
    info, distance = layers.grid.info, layers.distance
    ways = np.column_stack((np.cos(angles), np.sin(angles)))
    gone, away = np.zeros(len(angles)), np.full(len(angles), np.inf)
    on = np.arange(len(angles))
    while len(on):
        cells = info.to_cells(np.array((laser.x, laser.y)) + gone[on, None] * ways[on])
        inside = ((cells >= 0) & (cells < info.shape)).all(axis=1)
        on, cells = on[inside], cells[inside]
        free = distance[cells[:, 0], cells[:, 1]].astype(np.float64)
        met = free == 0.0
        away[on[met]] = gone[on[met]]
        gone[on] += np.maximum(0.5 * info.resolution, free - BETWEEN * info.resolution)
        on = on[~met & (gone[on] < most)]
    return away
