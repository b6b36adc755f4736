"""Likelihood fields (*Probabilistic Robotics*, 6.4): rate each beam by the distance from its end to an obstacle."""

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.localization.beams import choose_beams, scan_points, spread, thinned
from ppaas.localization.distance_filter import ends_at_people
from ppaas.localization.kernels import likelihood_field
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.sensor_model import Fit, SensorModel
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.thread_budget import Threads

_LEAST = 1e-300
"""Smallest likelihood, so that its logarithm is finite."""


class LikelihoodField(SensorModel):
    """Sensor model ``likelihood_field``, which sums up the cubes of the beams' likelihoods."""

    def __init__(self, layers: MapLayers, parameters: AmclParameters, threads: Threads) -> None:
        super().__init__(layers, parameters, threads)
        self._layers = layers
        self._table: tuple[float, NDArray[np.int64]] | None = None

    def beams_and_hits(
        self, scan: LaserScan, laser: Pose2D, most: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the results of `beams` and of `hits`, which are chosen from the same points."""
        points = thinned(scan_points(self._limited(scan), laser))
        return spread(points, self._parameters.laser_max_beams), spread(points, most)

    def informative(self, beams: NDArray[np.float64], pose: Pose2D) -> NDArray[np.float64]:
        """Return the beams that do not end at people who crowd around the robot."""
        return beams[~ends_at_people(pose, beams, self._layers)]

    def _choose(self, scan: LaserScan, laser: Pose2D) -> NDArray[np.float64]:
        return choose_beams(scan_points(scan, laser), self._parameters.laser_max_beams)

    def _sums(
        self, particles: NDArray[np.float64], beams: NDArray[np.float64], range_max: float, *, parallel: bool
    ) -> NDArray[np.float64]:
        score = likelihood_field.score_parallel if parallel else likelihood_field.score_serial
        table = self._table_for(range_max)
        return score(particles, beams, self._distance, self._resolution, self._origin, table)

    def _table_for(self, range_max: float) -> NDArray[np.int64]:
        if self._table is None or self._table[0] != range_max:
            p = self._parameters
            likelihoods = likelihood_field.likelihoods(
                self._resolution,
                p.laser_z_hit,
                p.laser_z_rand / range_max,
                p.laser_sigma_hit,
                p.laser_likelihood_max_dist,
            )
            terms = np.rint(self._terms(likelihoods) * likelihood_field.ONE).astype(np.int64)
            self._table = range_max, terms
        return self._table[1]

    def _terms(self, likelihoods: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the terms that beams of these likelihoods add to the sum of a particle."""
        return likelihoods**3


class LikelihoodFieldProb(LikelihoodField):
    """Sensor model ``likelihood_field_prob``, which multiplies the likelihoods as if beams were independent."""

    def _terms(self, likelihoods: NDArray[np.float64]) -> NDArray[np.float64]:
        logarithms: NDArray[np.float64] = np.log(np.maximum(likelihoods, _LEAST))
        return logarithms

    def _fit(self, sums: NDArray[np.float64], beams: int) -> Fit:
        return Fit(np.exp(sums - sums.max()), np.exp(sums / beams))
