"""Kernel: points of a scan, corrected for the motion of the laser, and normals of the lines fitted around them."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

NEAR, NEAR_GROWTH = 0.10, 0.05
"""Radius of the neighbourhood of a point [m], and its growth with the range [m/m]: points lie farther apart."""

SPARSE, SPARSE_GROWTH = 1.05, 0.4
"""Radius where the neighbourhood has few points: in spacings of the points, and its limit by the range [m/m]."""

LONG = 4.0
"""Least ratio of the variances along and across a line."""

FEWEST = 3
"""Fewest points of a line."""


@compiled
def _fit(
    points: NDArray[np.float32],
    valid: NDArray[np.bool_],
    beam: int,
    side: int,
    radius: float,
    thickness: float,
    normal: NDArray[np.float32],
) -> bool:
    """Fit a line to the neighbours of a point within a radius; return whether there are enough of them.

    Parameters
    ----------
    points, valid, side, thickness
        See `prepare`.
    beam : int
        Beam of the point.
    radius : float
        Largest distance of a neighbour [m].
    normal : (2,) float32 array
        Modified: the unit normal towards the laser, if the neighbours lie on a line.
    """
    # Total least squares, about the point so that float32 suffices.
    x, y = points[beam, 0], points[beam, 1]
    count, sx, sy, sxx, sxy, syy = 0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(max(0, beam - side), min(valid.size, beam + side + 1)):
        dx, dy = points[k, 0] - x, points[k, 1] - y
        if valid[k] and dx * dx + dy * dy <= radius * radius:
            count += 1
            sx, sy = sx + dx, sy + dy
            sxx, sxy, syy = sxx + dx * dx, sxy + dx * dy, syy + dy * dy
    if count < FEWEST:
        return False
    sx, sy = sx / count, sy / count
    sxx, sxy, syy = sxx / count - sx * sx, sxy / count - sx * sy, syy / count - sy * sy
    along = 0.5 * math.atan2(2.0 * sxy, sxx - syy)
    nx, ny = -math.sin(along), math.cos(along)
    across = nx * nx * sxx + 2.0 * nx * ny * sxy + ny * ny * syy
    if across <= thickness * thickness and sxx + syy - across >= LONG * across:
        towards = -1.0 if nx * x + ny * y > 0.0 else 1.0
        normal[0], normal[1] = towards * nx, towards * ny
    return True


@compiled
def _spacing(points: NDArray[np.float32], valid: NDArray[np.bool_], beam: int) -> float:
    """Return the larger distance from a point to those of the beams beside it [m]; 0 unless both have readings."""
    if beam == 0 or beam + 1 >= valid.size or not (valid[beam - 1] and valid[beam + 1]):
        return 0.0
    return max(
        math.hypot(points[beam, 0] - points[beam - 1, 0], points[beam, 1] - points[beam - 1, 1]),
        math.hypot(points[beam, 0] - points[beam + 1, 0], points[beam, 1] - points[beam + 1, 1]),
    )


@compiled
def prepare(
    ranges: NDArray[np.float32],
    angle_min: float,
    angle_increment: float,
    least: float,
    most: float,
    beam_motion: NDArray[np.float64],
    stamped_beam: float,
    side: int,
    thickness: float,
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]:
    """Return points, normals towards the laser, and whether there is a reading, one row per beam.

    Parameters
    ----------
    ranges : (b,) float32 array
        Ranges [m]; outside (``least``, ``most``), NaN included, there is no reading.
    angle_min, angle_increment : float
        Direction of beam 0, and from each beam to the next [rad].
    least, most : float
        Limits of readings [m].
    beam_motion : (3,) float64 array
        Motion of the laser between two beams, in its own frame: x, y [m], theta [rad].
    stamped_beam : float
        Beam at which the laser is at its pose; a fraction lies between two beams.
    side : int
        Number of beams to each side whose points a line is fitted to.
    thickness : float
        Largest standard deviation across a line [m].

    Returns
    -------
    points : (b, 2) float32 array
        x, y [m] in the frame of the laser at its pose; 0 without a reading.
    normals : (b, 2) float32 array
        Unit normals towards the laser; (0, 0) without a line.
    valid : (b,) bool array
    """
    beams = ranges.size
    points = np.zeros((beams, 2), np.float32)
    normals = np.zeros((beams, 2), np.float32)
    valid = np.zeros(beams, np.bool_)
    # Points. The laser is at f beam motions from its pose when it measures a beam.
    for b in range(beams):
        reach = ranges[b]
        if least < reach < most:
            f = b - stamped_beam
            angle = angle_min + angle_increment * b + f * beam_motion[2]
            valid[b] = True
            points[b, 0] = reach * math.cos(angle) + f * beam_motion[0]
            points[b, 1] = reach * math.sin(angle) + f * beam_motion[1]
    # Normals. Points of a wall at a glancing angle lie far apart: only where few points are near, its neighbours count.
    for b in range(beams):
        if not valid[b]:
            continue
        radius = NEAR + NEAR_GROWTH * ranges[b]
        if not _fit(points, valid, b, side, radius, thickness, normals[b]):
            wide = min(SPARSE * _spacing(points, valid, b), SPARSE_GROWTH * ranges[b])
            if wide > radius:
                _fit(points, valid, b, side, wide, thickness, normals[b])
    return points, normals, valid


def warm() -> None:
    """Call the kernel once, so that it is compiled or loaded from the cache."""
    prepare(np.ones(4, np.float32), 0.0, 0.01, 0.05, 40.0, np.zeros(3), 1.5, 2, 0.03)
