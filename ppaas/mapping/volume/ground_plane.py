"""Ground filter: the points of a cloud that are of the floor, as ``octomap_server`` finds them.

It searches for the largest level plane (RANSAC: Fischler and Bolles, 1981). If that is not near z = 0, such as the top
of a table, it is set aside, and the search continues in the other points.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, check_numbers

FEWEST = 50
"""Number of points below which a cloud is not searched."""

TRIALS = 200
"""Number of planes that are tried, as in octomap_server."""

MOST_COUNTED = 2000
"""Number of points that are counted for each plane."""

PLANES = 8
"""Number of planes that are set aside before the search ends."""


class GroundFilterParameters(Parameters, frozen=True):
    """Parameters of the ground filter.

    Parameters
    ----------
    distance : float
        Distance from the plane up to which a point belongs to it [m].
    angle : float
        Largest angle between the plane and the horizontal [rad].
    plane_distance : float
        Largest distance of the plane from the origin of the robot's frame [m].
    """

    distance: float = 0.04
    angle: float = 0.15
    plane_distance: float = 0.07

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=self.__struct_fields__)
        if self.angle >= math.pi / 2.0:
            raise InvalidParameter(f"the angle of the ground filter must be below π/2, not {self.angle}")


def ground_mask(points: NDArray[np.float32], parameters: GroundFilterParameters) -> NDArray[np.bool_]:
    """Return whether each point is of the floor, (n,).

    If no floor is found, it is the points within ``plane_distance`` of z = 0. In a cloud of fewer than `FEWEST` points,
    none is.

    Parameters
    ----------
    points : (n, 3) float32 array
        Points in the frame of the robot's body, z upwards [m].
    parameters : GroundFilterParameters
    """
    mask = np.zeros(len(points), np.bool_)
    rest = np.flatnonzero(np.isfinite(points).all(axis=1))
    if len(rest) < FEWEST:
        return mask
    random = np.random.default_rng(0)  # the same cloud always gives the same floor
    for _ in range(PLANES):
        plane = _largest_plane(points[rest].astype(np.float64), parameters, random)
        if plane is None:
            break
        normal, offset = plane
        within = np.abs(points[rest] @ normal - offset) <= parameters.distance
        if abs(offset) < parameters.plane_distance:
            mask[rest[within]] = True
            return mask
        rest = rest[~within]
    mask[np.abs(points[:, 2]) <= parameters.plane_distance] = True
    return mask


def _largest_plane(
    points: NDArray[np.float64], parameters: GroundFilterParameters, random: np.random.Generator
) -> tuple[NDArray[np.float64], float] | None:
    """Return the unit normal and the distance from the origin of the level plane with the most points; None if none."""
    if len(points) < FEWEST:
        return None
    a, b, c = points[random.integers(0, len(points), (3, TRIALS))]
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    level = np.abs(normals[:, 2]) >= math.cos(parameters.angle) * lengths
    level &= lengths > 0.0
    if not level.any():
        return None
    normals = normals[level] / lengths[level, None]
    offsets = (normals * a[level]).sum(axis=1)
    counted = points[random.integers(0, len(points), min(MOST_COUNTED, len(points)))]
    best = int((np.abs(counted @ normals.T - offsets) <= parameters.distance).sum(axis=0).argmax())
    near = points[np.abs(points @ normals[best] - offsets[best]) <= parameters.distance]
    centre = near.mean(axis=0)
    normal = np.linalg.eigh(np.cov((near - centre).T))[1][:, 0]  # least squares over all its points
    if abs(normal[2]) < math.cos(parameters.angle):
        normal = normals[best]
    return normal, float(normal @ centre)
