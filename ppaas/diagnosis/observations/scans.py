"""Facts of scans: their angles, limits and ranges; and how much of a scan the map explains."""

import math

import numpy as np

from ppaas.costmap.map_layers import MapLayers
from ppaas.diagnosis.observations.facts import ScanFacts
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.localization.beams import excess_of, scan_points
from ppaas.messages.sensor_msgs import LaserScan

NEAR_WALL = 0.3
"""Distance from a wall of the map within which the end of a beam is explained by it [m]."""

FEWEST_BEAMS = 10
"""Number of readings below which the fit of the scan is not judged."""


def scan_facts(scan: LaserScan) -> ScanFacts:
    """Return the facts of a scan, whatever is wrong with it."""
    ranges = np.array([math.nan if each is None else each for each in scan.ranges], np.float64)
    count = max(len(ranges), 1)
    with np.errstate(invalid="ignore"):
        readings = (ranges > scan.range_min) & (ranges < scan.range_max)
        short = (ranges > 0.0) & (ranges < scan.range_min)
    return ScanFacts(
        frame=scan.header.frame_id.lstrip("/"),
        beams=len(scan.ranges),
        excess=excess_of(scan),
        increment=scan.angle_increment,
        range_min=scan.range_min,
        range_max=scan.range_max,
        readings=float(np.count_nonzero(readings)) / count,
        zeros=float(np.count_nonzero(ranges == 0.0)) / count,
        empty=float(np.count_nonzero(~np.isfinite(ranges))) / count,
        short=float(np.count_nonzero(short)) / count,
        intensities=len(scan.intensities),
    )


def explained(scan: LaserScan, laser: Pose2D, layers: MapLayers) -> float | None:
    """Return the share of the readings of a scan that end at a wall of the map.

    Parameters
    ----------
    scan : LaserScan
    laser : Pose2D
        Pose of the laser in the map.
    layers : MapLayers

    Returns
    -------
    float or None
        None if the scan has less than `FEWEST_BEAMS` readings, or is not valid.
    """
    try:
        points = scan_points(scan, laser)
    except PPaaSError:
        return None
    if len(points) < FEWEST_BEAMS:
        return None
    cells = layers.grid.info.to_cells(points)
    height, width = layers.grid.info.shape
    inside = (cells >= 0).all(axis=1) & (cells[:, 0] < height) & (cells[:, 1] < width)
    distances = layers.distance[cells[inside, 0], cells[inside, 1]]
    return float(np.count_nonzero(distances <= NEAR_WALL)) / len(points)
