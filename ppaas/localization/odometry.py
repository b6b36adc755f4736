"""Odometry models: move particles by a measured motion plus noise.

The ``-corrected`` models are from *Probabilistic Robotics*, table 5.6. amcl's ``diff`` and ``omni``
(``amcl_odom.cpp``) use the variance as the standard deviation.
"""

import math
from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.kernel_threads import limit_threads
from ppaas.localization.kernels import motion
from ppaas.localization.parameters import AmclParameters
from ppaas.thread_budget import Threads

PARALLEL_FROM = 1 << 13
"""Number of particles below which one thread is as fast as several."""

_TURN_IN_PLACE = 0.01
"""Distance below which a motion counts as a turn in place, since its direction is noise [m] (``amcl_odom.cpp``)."""

_CORRECTED = "-corrected"


class OdometryModel(ABC):
    """Moves particles by the motion that odometry measured, plus noise.

    Parameters
    ----------
    parameters : AmclParameters
    threads : callable
        Returns the largest number of threads that kernels may use now; it does not affect the result.
    """

    def __init__(self, parameters: AmclParameters, threads: Threads) -> None:
        p = parameters
        self._alphas = (p.odom_alpha1, p.odom_alpha2, p.odom_alpha3, p.odom_alpha4, p.odom_alpha5)
        self._corrected = p.odom_model_type.endswith(_CORRECTED)
        self._threads = threads

    def move(self, particles: NDArray[np.float64], before: Pose2D, after: Pose2D, random: np.random.Generator) -> None:
        """Move particles in place.

        Parameters
        ----------
        particles : (n, 3) array
            x, y [m], theta [rad].
        before, after : Pose2D
            Poses of the robot in the odometry frame.
        random : numpy.random.Generator
            Source of the noise.
        """
        moved, variances = self._measured(before, after)
        first, second, third = (math.sqrt(v) if self._corrected else v for v in variances)
        normals = random.standard_normal((len(particles), 3))
        with limit_threads(self._threads() if len(particles) >= PARALLEL_FROM else 1) as threads:
            self._kernel(parallel=threads > 1)(particles, moved, (first, second, third), normals)

    @abstractmethod
    def _measured(self, before: Pose2D, after: Pose2D) -> tuple[motion.Motion, motion.Motion]:
        """Return the three components of the motion, and the variance of the noise of each."""

    @abstractmethod
    def _kernel(self, *, parallel: bool) -> motion.Move: ...


class Differential(OdometryModel):
    """Model ``diff``: a turn, a straight line, and another turn."""

    def _measured(self, before: Pose2D, after: Pose2D) -> tuple[motion.Motion, motion.Motion]:
        distance = before.distance_to(after)
        first = wrap_angle(_heading(before, after) - before.theta) if distance >= _TURN_IN_PLACE else 0.0
        second = wrap_angle(after.theta - before.theta - first)
        a1, a2, a3, a4, _ = self._alphas
        turned = (_from_straight(first) ** 2, _from_straight(second) ** 2)
        square = distance * distance
        variances = (a1 * turned[0] + a2 * square, a3 * square + a4 * sum(turned), a1 * turned[1] + a2 * square)
        return (first, distance, second), variances

    def _kernel(self, *, parallel: bool) -> motion.Move:
        return motion.move_diff_parallel if parallel else motion.move_diff_serial


class Omnidirectional(OdometryModel):
    """Model ``omni``: a translation in any direction, and a turn."""

    def _measured(self, before: Pose2D, after: Pose2D) -> tuple[motion.Motion, motion.Motion]:
        distance, turn = before.distance_to(after), wrap_angle(after.theta - before.theta)
        a1, a2, a3, a4, a5 = self._alphas
        moved, turned = distance * distance, turn * turn
        variances = (a3 * moved + a1 * turned, a1 * turned + a5 * moved, a4 * turned + a2 * moved)
        return (wrap_angle(_heading(before, after) - before.theta), distance, turn), variances

    def _kernel(self, *, parallel: bool) -> motion.Move:
        return motion.move_omni_parallel if parallel else motion.move_omni_serial


def odometry_model(parameters: AmclParameters, threads: Threads) -> OdometryModel:
    """Return the odometry model named by ``odom_model_type``."""
    kind = Omnidirectional if parameters.odom_model_type.startswith("omni") else Differential
    return kind(parameters, threads)


def _heading(before: Pose2D, after: Pose2D) -> float:
    return math.atan2(after.y - before.y, after.x - before.x)


def _from_straight(turn: float) -> float:
    """Return the angle between a turn and straight ahead or straight back, so that reversing is not a half turn."""
    return min(abs(wrap_angle(turn)), abs(wrap_angle(turn - math.pi)))
