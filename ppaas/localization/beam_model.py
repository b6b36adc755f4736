"""Beam model of the laser (*Probabilistic Robotics*, 6.3): compares each range with the range cast in the map."""

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.localization.beams import choose_rays
from ppaas.localization.kernels import beam_model
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.sensor_model import SensorModel
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.thread_budget import Threads


class BeamModel(SensorModel):
    """Sensor model ``beam``, several times as slow as a likelihood field."""

    def __init__(self, layers: MapLayers, parameters: AmclParameters, threads: Threads) -> None:
        super().__init__(layers, parameters, threads)
        p = parameters
        self._shares = beam_model.BeamShares(
            p.laser_z_hit, p.laser_z_short, p.laser_z_max, p.laser_z_rand, p.laser_sigma_hit, p.laser_lambda_short
        )

    def _choose(self, scan: LaserScan, laser: Pose2D) -> NDArray[np.float64]:
        return choose_rays(scan, laser, self._parameters.laser_max_beams)

    def points(self, beams: NDArray[np.float64], range_max: float) -> NDArray[np.float64]:
        """Return the end points of the beams that are shorter than ``range_max``."""
        x, y, angle, length = beams[beams[:, 3] < range_max].T
        return np.column_stack((x + length * np.cos(angle), y + length * np.sin(angle)))

    def _sums(
        self, particles: NDArray[np.float64], beams: NDArray[np.float64], range_max: float, *, parallel: bool
    ) -> NDArray[np.float64]:
        score = beam_model.score_parallel if parallel else beam_model.score_serial
        return score(particles, beams, self._distance, self._resolution, self._origin, self._shares, range_max)
