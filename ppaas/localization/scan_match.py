"""How well what was seen fits the map, whatever model of the laser weighs the particles."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.localization.kernels import likelihood_field
from ppaas.localization.kernels.sight import account_for
from ppaas.localization.parameters import AmclParameters

SOMEBODY = 0.5
"""How well that somebody stands there accounts for a ray that ends in the open."""


class Match:
    """Compares points with a map, by how far each is from an obstacle.

    Parameters
    ----------
    layers : MapLayers
        The map; its ``distance`` is read.
    parameters : AmclParameters
    """

    def __init__(self, layers: MapLayers, parameters: AmclParameters) -> None:
        info = layers.grid.info
        self._distance, self._resolution, self._origin = layers.distance, info.resolution, np.array(info.origin)
        # As narrow as what the likelihood field adds to a weight: the cube of a Gaussian.
        self._sigma = parameters.laser_sigma_hit / math.sqrt(3.0)
        self._far = parameters.laser_likelihood_max_dist

    def fits(self, poses: NDArray[np.float64], points: NDArray[np.float64], wide: float = 1.0) -> NDArray[np.float64]:
        """Return how well points fit as seen from each of some poses, from 0 to 1.

        Parameters
        ----------
        poses : (n, 3) array
            x, y [m], theta [rad] in the map frame.
        points : (m, 2) array
            In the robot's frame [m]; one at least.
        wide : float
            How many times as far a point may be off.
        """
        gauss = likelihood_field.likelihoods(self._resolution, 1.0, 0.0, wide * self._sigma, self._far)
        table = np.rint(gauss * likelihood_field.ONE).astype(np.int64)
        sums = likelihood_field.score_serial(poses, points, self._distance, self._resolution, self._origin, table)
        found: NDArray[np.float64] = sums / len(points)
        return found

    def accounts(self, poses: NDArray[np.float64], rays: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how well the map accounts for rays as seen from each of some poses, from 0 to 1.

        Unlike `fits`, it holds against a pose that walls would have been in the way, and less that rays end in the
        open: people stand there, who are in no map.

        Parameters
        ----------
        poses : (n, 3) array
            x, y [m], theta [rad] in the map frame.
        rays : (m, 4) array
            x, y where each ended, and where it began, in the robot's frame [m]; one at least.
        """
        sums: NDArray[np.float64] = account_for(
            poses, rays, self._distance, self._resolution, self._origin, self._sigma, SOMEBODY
        )
        return sums / len(rays)
