"""Scan matching: rates how well beams fit the map, independent of the sensor model that weights the particles."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.localization.kernels import likelihood_field
from ppaas.localization.kernels.sight import explain_rays
from ppaas.localization.parameters import AmclParameters

PERSON = 0.5
"""Rating of a beam that ends in free space, where a person may stand."""


class ScanMatch:
    """Rates poses by the distances from the ends of beams to the nearest obstacles.

    Parameters
    ----------
    layers : MapLayers
        The map; its ``distance`` is read.
    parameters : AmclParameters
    """

    def __init__(self, layers: MapLayers, parameters: AmclParameters) -> None:
        info = layers.grid.info
        self._distance, self._resolution, self._origin = layers.distance, info.resolution, np.array(info.origin)
        # The likelihood field adds the cube of a Gaussian to a weight: as narrow as a Gaussian of σ/√3.
        self._sigma = parameters.laser_sigma_hit / math.sqrt(3.0)
        self._far = parameters.laser_likelihood_max_dist
        self._tables: dict[float, NDArray[np.int64]] = {}
        self._inside: NDArray[np.int64] | None = None

    def fits(self, poses: NDArray[np.float64], points: NDArray[np.float64], wide: float = 1.0) -> NDArray[np.float64]:
        """Return the fit of points to the map as seen from each pose, from 0 to 1.

        Parameters
        ----------
        poses : (n, 3) array
            x, y [m], theta [rad] in the map frame.
        points : (m, 2) array
            End points of beams in the robot's frame [m]; at least one.
        wide : float
            Factor of the standard deviation of a point.
        """
        table = self._tables.get(wide)
        if table is None:
            table = self._tables[wide] = np.rint(self._gauss(wide) * likelihood_field.ONE).astype(np.int64)
        return self._mean(poses, points, table)

    def surface_fits(self, poses: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the fit of points to the surfaces of walls as seen from each pose, up to 1.

        By `fits`, a pose is as good if the points are deep in a wall, which would pull a robot that sees few walls by
        half of their thickness. Here a point counts as one cell away if it is still in the wall one cell nearer to the
        robot.

        Parameters
        ----------
        poses, points
            As for `fits`.
        """
        if self._inside is None:
            gauss = self._gauss(1.0)
            self._inside = np.zeros(len(gauss), np.int64)
            self._inside[0] = np.rint((gauss[1] - gauss[0]) * likelihood_field.ONE)
        ranges = np.hypot(points[:, 0], points[:, 1])
        nearer = points * (1.0 - self._resolution / np.maximum(ranges, self._resolution))[:, np.newaxis]
        return self.fits(poses, points) + self._mean(poses, nearer, self._inside)

    def _gauss(self, wide: float) -> NDArray[np.float64]:
        return likelihood_field.likelihoods(self._resolution, 1.0, 0.0, wide * self._sigma, self._far)

    def _mean(
        self, poses: NDArray[np.float64], points: NDArray[np.float64], table: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        """Return the mean term of a table over the points, as seen from each pose."""
        sums = likelihood_field.score_serial(poses, points, self._distance, self._resolution, self._origin, table)
        found: NDArray[np.float64] = sums / len(points)
        return found

    def accounts(self, poses: NDArray[np.float64], rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how well the map explains rays as seen from each pose, from 0 to 1.

        Unlike `fits`, it rates a ray low that would have had to pass through a wall, and is more lenient with a ray
        that ends in free space, where an unmapped person may stand.

        Parameters
        ----------
        poses : (n, 3) array
            x, y [m], theta [rad] in the map frame.
        rays : (m, 4) array
            x, y of the end and x, y of the origin of each ray, in the robot's frame [m]; at least one.
        """
        sums: NDArray[np.float64] = explain_rays(
            poses, rays, self._distance, self._resolution, self._origin, self._sigma, PERSON
        )
        return sums / len(rays)
