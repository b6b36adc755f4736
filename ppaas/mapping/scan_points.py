"""Scans as points and normals in the laser frame, corrected for the motion of the laser during the sweep."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.kernels import points as kernels
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.parameters import SlamParameters

STILL = (0.0, 0.0, 0.0)
"""Velocity of a laser at rest."""

FEWEST_SIDE = 2
"""Fewest beams to each side of a point that a line is fitted to."""


class ScanPoints(NamedTuple):
    """Scan in the frame of the laser, one row per beam.

    Parameters
    ----------
    points : (b, 2) float32 array
        x, y of the end of each beam [m]. Without a reading it is 0, or the place up to which the beam is free.
    normals : (b, 2) float32 array
        Unit normal of the surface at each point, towards the laser; (0, 0) where no line fits its neighbours.
    valid : (b,) bool array
        Whether the beam has a reading.
    """

    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    valid: NDArray[np.bool_]


def prepare(
    ranges: ArrayLike, geometry: LaserGeometry, parameters: SlamParameters, velocity: ArrayLike = STILL
) -> ScanPoints:
    """Return the points and normals of a scan.

    Parameters
    ----------
    ranges : (b,) array
        Ranges [m]; NaN, and values outside (``minimum_laser_range``, ``max_laser_range``), are not readings.
    geometry : LaserGeometry
        Directions and times of the beams.
    parameters : SlamParameters
        Ranges and the fit of lines.
    velocity : (3,) array
        Velocity of the laser in its own frame during the sweep: x, y [m/s], theta [rad/s]; see `laser_motion`.

    Raises
    ------
    InvalidInput
        The number of ranges is not the number of beams.
    """
    values = np.asarray(ranges, np.float32)
    if values.shape != (geometry.beams,):
        raise InvalidInput(f"a scan of this laser must have {geometry.beams} ranges, not {values.size}")
    return ScanPoints(
        *kernels.prepare(
            values,
            geometry.angle_min,
            geometry.angle_increment,
            parameters.minimum_laser_range,
            parameters.max_laser_range,
            np.asarray(velocity, np.float64) * geometry.time_increment,
            geometry.stamped_at * (geometry.beams - 1),
            max(FEWEST_SIDE, round(parameters.normal_angle / abs(geometry.angle_increment))),
            parameters.normal_thickness,
        )
    )


def with_open_beams(
    scan: ScanPoints, beams: NDArray[np.bool_], reach: float, geometry: LaserGeometry, velocity: ArrayLike = STILL
) -> ScanPoints:
    """Return a scan some of whose beams without a reading are free up to a range.

    Parameters
    ----------
    scan : ScanPoints
    beams : (b,) bool array
        The beams that are free; those with a reading stay as they are.
    reach : float
        Range [m].
    geometry, velocity
        As for `prepare`.
    """
    free = np.flatnonzero(beams & ~scan.valid)
    if not len(free):
        return scan
    motion = np.asarray(velocity, np.float64) * geometry.time_increment
    apart = free - geometry.stamped_at * (geometry.beams - 1)  # beam motions from the pose of the scan
    angles = geometry.angle_min + geometry.angle_increment * free + apart * motion[2]
    points = scan.points.copy()
    points[free] = reach * np.column_stack((np.cos(angles), np.sin(angles))) + apart[:, np.newaxis] * motion[:2]
    return scan._replace(points=points)


# -- scans without the points on known robots --------------------------------------------------------------------------


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
