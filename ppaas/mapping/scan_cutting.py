"""Scans without the points on things that are known to be no part of the map, such as other robots."""

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.scan_points import ScanPoints


def without_discs(scan: ScanPoints, laser: Pose2D, discs: NDArray[np.float64]) -> ScanPoints:
    """Return a scan in which beams that end on discs have no reading.

    Parameters
    ----------
    scan : ScanPoints
        Returned unchanged if no beam ends on a disc.
    laser : Pose2D
        Pose of the laser in the map frame.
    discs : (m, 3) array
        Centres in the map frame and radii [m].
    """
    if not len(discs):
        return scan
    centres = [laser.inverse() @ Pose2D(x, y, 0.0) for x, y in discs[:, :2].tolist()]
    seen = np.array([(centre.x, centre.y) for centre in centres])
    away = np.square(scan.points[:, None, :] - seen).sum(axis=2)
    cut = scan.valid & (away <= np.square(discs[:, 2])).any(axis=1)
    if not cut.any():
        return scan
    # Lines were fitted to neighbouring points, too: normals beside a cut lean on the points cut.
    beside = cut.copy()
    beside[:-1] |= cut[1:]
    beside[1:] |= cut[:-1]
    points, normals = scan.points.copy(), scan.normals.copy()
    points[cut] = 0.0
    normals[beside] = 0.0
    return ScanPoints(points, normals, scan.valid & ~cut)
