"""Registration of point clouds against the map so far, by the library ``small_gicp`` (extra ``mapping``).

Method: voxelized generalized ICP (Segal et al., "Generalized-ICP", RSS 2009; Koide et al., "Voxelized GICP for Fast and
Accurate 3D Point Cloud Registration", ICRA 2021).
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.distribution import install_hint
from ppaas.errors import Unavailable
from ppaas.thread_budget import Threads, one_thread

THINNING = 0.05
"""Distance between the points of a cloud that are aligned [m]."""

CELL = 0.1
"""Edge of the cells of the model, each of which has a mean and a covariance, and farthest pair of points [m]."""

TRUST = 0.8
"""Part of a correction that is applied. The rest draws the clouds back to their poses: without it, small errors add up
to a drift (84 depth images with noise of 0.046 m: 0.059 m with all of it, 0.026 m with this part)."""

FEWEST = 100
"""Number of points below which a cloud is not aligned."""

LEAST_OVERLAP = 0.5
"""Part of the points that must have a cell of the model."""

HORIZON = 100
"""Number of clouds after which a cell that none has touched is forgotten."""

MOST_SHIFT = 0.3
"""Largest correction of a position [m]; a larger one is not trusted."""

MOST_TURN = math.radians(10.0)
"""Largest correction of an orientation [rad]."""

Transform = NDArray[np.float64]
"""(4, 4): from the map frame to the map frame."""


class CloudRegistration:
    """Corrects the poses of clouds, each against those before.

    Parameters
    ----------
    threads : callable
        Returns the number of threads.

    Raises
    ------
    Unavailable
        The library is not installed.
    """

    def __init__(self, threads: Threads = one_thread) -> None:
        self._library = library()
        self._threads = threads
        self._model: Any = None
        self._middle = np.zeros(3)

    def forget(self) -> None:
        """Forget the clouds, whose places have changed."""
        self._model = None

    def correction(self, points: NDArray[np.float32]) -> Transform:
        """Return the transform that puts a cloud where it fits, and remember the cloud.

        It is the identity as long as there is nothing to compare with, or if the clouds do not agree.

        Parameters
        ----------
        points : (n, 3) float32 array
            Points in the map frame, by the pose that is to be corrected [m].
        """
        finite = points[np.isfinite(points).all(axis=1)].astype(np.float64)
        if len(finite) < FEWEST:
            return np.eye(4)
        threads, correction = self._threads(), np.eye(4)
        if self._model is None:
            # Far from the origin of the map, a turn about it would move the cloud more than what is to be found.
            self._middle = finite.mean(axis=0)
        cloud, _ = self._library.preprocess_points(
            finite - self._middle, downsampling_resolution=THINNING, num_threads=threads
        )
        if self._model is None:
            self._model = self._library.GaussianVoxelMap(CELL)
            self._model.set_lru(horizon=HORIZON, clear_cycle=10)
        elif cloud.size() >= FEWEST:
            correction = self._aligned(cloud, threads)
        self._model.insert(cloud, correction)
        return _about(self._middle, correction)

    def _aligned(self, cloud: Any, threads: int) -> Transform:
        result = self._library.align(
            self._model, cloud, np.eye(4), max_correspondence_distance=CELL, num_threads=threads
        )
        if not result.converged or result.num_inliers < LEAST_OVERLAP * cloud.size():
            return np.eye(4)
        return _part(np.array(result.T_target_source), np.asarray(cloud.points())[:, :3].mean(axis=0))


def library() -> Any:
    """Return the module ``small_gicp``.

    Raises
    ------
    Unavailable
        It is not installed.
    """
    try:
        import small_gicp  # noqa: PLC0415  # of the extra mapping
    except ImportError as error:
        raise Unavailable(
            "registration of point clouds needs the library small_gicp where containers run: " + install_hint("mapping")
        ) from error
    return small_gicp


def apply(transform: Transform, points: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return points (n, 3) after a transform, as float32."""
    moved: NDArray[np.float32] = (points @ transform[:3, :3].T + transform[:3, 3]).astype(np.float32)
    return moved


def _about(middle: NDArray[np.float64], transform: Transform) -> Transform:
    """Return a transform of points relative to a place as one of the points themselves."""
    moved = transform.copy()
    moved[:3, 3] += middle - transform[:3, :3] @ middle
    return moved


def _part(found: Transform, middle: NDArray[np.float64]) -> Transform:
    """Return the part `TRUST` of a transform about the middle of a cloud; the identity if it is too large.

    Source of the rotation vector and of its matrix: Rodrigues' formula.
    """
    turn, shift = found[:3, :3], found[:3, :3] @ middle + found[:3, 3] - middle
    angle = math.acos(min(1.0, max(-1.0, (float(np.trace(turn)) - 1.0) / 2.0)))
    if not (float(np.linalg.norm(shift)) <= MOST_SHIFT and angle <= MOST_TURN):
        return np.eye(4)
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    length = float(np.linalg.norm(axis))
    x, y, z = axis / length if length > 0.0 else axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    part = np.eye(4)
    part[:3, :3] += math.sin(TRUST * angle) * cross + (1.0 - math.cos(TRUST * angle)) * cross @ cross
    part[:3, 3] = middle + TRUST * shift - part[:3, :3] @ middle
    return part
