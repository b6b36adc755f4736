"""Correlative search: the start of an alignment, on a grid of the likelihood of points near key frames.

Source: Olson, *Real-Time Correlative Scan Matching* (ICRA 2009), without its coarse level, as the windows are small.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.kernels import correlation as kernels
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.mapping.scan_points import ScanPoints

REACH = 25.0
"""Distance from the middle of the grid to its edges [m]."""

STRIDE = 2
"""Distance between the beams that are searched for [beams]."""

CUT = 2.2
"""Distance up to which a point adds likelihood [standard deviations]."""


class Window(NamedTuple):
    """Window of a search.

    Parameters
    ----------
    distance : float
        Largest difference of x and of y from the start [m].
    turn : float
        Largest difference of the heading from the start [rad].
    step : float
        Step of the heading [rad].
    """

    distance: float
    turn: float
    step: float


class CorrelationGrid:
    """Square grid of the likelihood that a point of a scan lies in a cell, by the distance to points of key frames.

    Parameters
    ----------
    resolution : float
        Edge of a cell [m].
    deviation : float
        Standard deviation of the distance between points of the same surface [m].
    reach : float
        Distance from the middle to the edges [m].
    """

    def __init__(self, resolution: float, deviation: float, reach: float = REACH) -> None:
        self._resolution, self._reach = resolution, reach
        self._blur = _blur(resolution, deviation)
        cells = math.ceil(2.0 * reach / resolution)
        self._grid = np.zeros((cells, cells), np.uint8)
        self._x0 = self._y0 = 0.0

    def draw(self, key_frames: KeyFrames, near: NearFrames, middle: Pose2D) -> None:
        """Replace the grid by one around a position, with the points of some key frames."""
        self._x0, self._y0 = middle.x - self._reach, middle.y - self._reach
        kernels.draw(
            self._grid, self._x0, self._y0, self._resolution, self._blur,
            near.indices, near.poses, key_frames.points, key_frames.normals, key_frames.valid,
        )  # fmt: skip

    def search(self, scan: ScanPoints, start: Pose2D, window: Window) -> tuple[Pose2D, float]:
        """Return the pose near a start at which a scan fits the grid best, and its fit from 0 to 1.

        If the scan fits nowhere, the pose is the start.
        """
        pose, fit = kernels.search(
            self._grid, self._x0, self._y0, self._resolution, scan.points, scan.valid, STRIDE, np.array(start),
            math.ceil(window.distance / self._resolution), math.ceil(window.turn / window.step), window.step,
        )  # fmt: skip
        return (Pose2D(*pose.tolist()) if fit > 0.0 else start), fit


def _blur(resolution: float, deviation: float) -> NDArray[np.uint8]:
    """Return the likelihood around a point, 255 in the middle."""
    half = math.ceil(CUT * deviation / resolution)
    along = np.arange(-half, half + 1) * resolution
    squared = along[:, np.newaxis] ** 2 + along**2
    blurred: NDArray[np.uint8] = np.round(255.0 * np.exp(-0.5 * squared / deviation**2)).astype(np.uint8)
    return blurred
