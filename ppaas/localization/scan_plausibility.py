"""Plausibility check of scans: detects a laser that is covered, broken or switched off."""

from collections.abc import Callable

import numpy as np

from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.localization.kernels.sight import to_walls
from ppaas.messages.sensor_msgs import LaserScan

MOST_RAYS = 36
"""Largest number of beams of a scan that are compared with the map."""

IN_REACH, MARGIN = 0.9, 0.3
"""A laser must see a wall that is nearer than this part of its longest range, and farther by this than its shortest
range [m]."""

SHOULD_SEE = 0.5
"""Part of the beams that must see a wall, from which a laser without readings counts as blind."""


def check_plausible(scan: LaserScan, layers: MapLayers, place: Callable[[], Pose2D | None]) -> None:
    """Reject a scan without readings if the laser must see walls: its robot would drive blind.

    A single beam without a reading is normal: drivers report null, NaN, infinity or 0 if nothing is in reach.

    Parameters
    ----------
    scan : LaserScan
        Its angles must be finite.
    layers : MapLayers
        The map.
    place : callable
        Returns the estimated pose of the laser in the map frame, or None; called only if no beam has a reading.

    Raises
    ------
    InvalidInput
        No beam has a reading, although by the map half of them should see a wall.
    """
    ranges = scan.ranges
    if not ranges or any(each is not None and scan.range_min < each < scan.range_max for each in ranges):
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
            "no beam of the scan has a reading, although by the map half of them should: check that the laser is on, "
            "and that the robot is at its estimated pose"
        )
