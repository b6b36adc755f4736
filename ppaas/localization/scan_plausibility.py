"""Telling a laser that is covered, broken or switched off from one around which there is nothing."""

from collections.abc import Callable

import numpy as np

from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.localization.kernels.sight import to_walls
from ppaas.messages.sensor_msgs import LaserScan

MOST_RAYS = 36
"""Beams of a scan that are compared with the map, at most."""

IN_REACH, MARGIN = 0.9, 0.3
"""A wall that a laser should see is no farther than this part of its longest range, and farther than its shortest by
this [m]."""

SHOULD_SEE = 0.5
"""Part of its beams that should see one, from which on a laser that sees nothing is blind."""


def check_sight(scan: LaserScan, layers: MapLayers, place: Callable[[], Pose2D | None]) -> None:
    """Refuse a scan of a laser that sees nothing, though it should: its robot would drive blind.

    That a beam has no reading tells nothing by itself: drivers say null, NaN, infinity or 0 where nothing is in reach.

    Parameters
    ----------
    scan : LaserScan
        Its angles are finite.
    layers : MapLayers
        The map.
    place : callable
        Returns where the laser is taken to be in the map, if that is known; asked only where no beam has a reading.

    Raises
    ------
    InvalidInput
        No beam has a reading, where the map has walls in sight of half of them.
    """
    ranges = scan.ranges
    if not ranges or any(each is not None and scan.range_min <= each < scan.range_max for each in ranges):
        return
    laser = place()
    if laser is None:
        return
    chosen = np.linspace(0, len(ranges) - 1, min(MOST_RAYS, len(ranges))).round()
    angles, info = scan.angle_min + scan.angle_increment * chosen, layers.grid.info
    away = to_walls(np.array(laser), angles, layers.distance, info.resolution, np.array(info.origin), scan.range_max)
    in_sight = (away > scan.range_min + MARGIN) & (away < IN_REACH * scan.range_max)
    if np.mean(in_sight) >= SHOULD_SEE:
        raise InvalidInput(
            "no beam of a scan has a reading, and by the map half of them should: is the laser on, and the robot where "
            "it is taken to be?"
        )
