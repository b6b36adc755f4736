"""Alignment of a scan with key frames: a correlative search, then Gauss-Newton over distances from points to lines."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.kernels import alignment as kernels
from ppaas.mapping.kernels import correlation
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.mapping.scan_points import ScanPoints


class AlignmentSettings(NamedTuple):
    """Settings of an alignment.

    Parameters
    ----------
    gates : tuple of float
        Largest distance of a pair in each iteration, descending [m].
    scale : float
        Distance at which the weight of a pair is a quarter (Geman-McClure) [m]; it grows with gates above 0.15 m.
    deviation : float
        Standard deviation of one distance, of which the information is calculated [m].
    beams : int
        Largest number of beams to each side of a point's bearing among which its pair is searched.
    """

    gates: tuple[float, ...] = (0.5, 0.3, 0.2, 0.15, 0.15, 0.15, 0.15)
    scale: float = 0.03
    deviation: float = 0.02
    beams: int = 8


CHECKING = AlignmentSettings()
"""Settings to check a loop closure."""

TRACKING = AlignmentSettings(deviation=0.05)
"""Settings to track a scan. Several key frames repeat one error, so each pair counts less."""

NO_PRIOR = (100.0, 100.0, 100.0)
"""Standard deviations that stand for no prior [m, m, rad]."""


class Prior(NamedTuple):
    """Gaussian that an aligned pose is drawn to.

    Parameters
    ----------
    pose : Pose2D
        Mean, in the map frame.
    deviations : tuple of float
        Standard deviations along x, y [m] and theta [rad] of the mean's own frame; above 0.
    """

    pose: Pose2D
    deviations: tuple[float, float, float]


class Aligned(NamedTuple):
    """Result of an alignment.

    Parameters
    ----------
    pose : Pose2D
        Pose of the laser in the map frame.
    information : (6,) float64 array
        Information xx, xy, xt, yy, yt, tt of the pose in the frame of the scan, including the prior's.
    ratio : float
        Part of the scan's points that have a pair in the key frame in which most have one, from 0 to 1.
    pairs : int
        Number of pairs in all key frames.
    """

    pose: Pose2D
    information: NDArray[np.float64]
    ratio: float
    pairs: int


def align(
    scan: ScanPoints,
    start: Pose2D,
    key_frames: KeyFrames,
    near: NearFrames,
    settings: AlignmentSettings = CHECKING,
    *,
    prior: Prior | None = None,
) -> Aligned:
    """Return the pose at which a scan fits key frames best, near a start.

    Each point is paired with the nearest point that has a normal, among the beams of a key frame around the point's
    bearing (projective association); the distance to its line is minimized over all pairs.

    Parameters
    ----------
    scan : ScanPoints
        Scan to align.
    start : Pose2D
        Pose of the laser in the map frame from which the iterations start.
    key_frames : KeyFrames
        Scans of the map, of the same laser.
    near : NearFrames
        Key frames to align with, and their poses, which stay fixed.
    settings : AlignmentSettings
        Gates and weights.
    prior : Prior, optional
        Expected pose. Without it, a pose that the pairs do not determine stays where it started.
    """
    geometry, expected = key_frames.geometry, prior.pose if prior else start
    deviations = np.array(prior.deviations if prior else NO_PRIOR)
    pose, information, ratio, pairs = kernels.align(
        *scan,
        np.array(start),
        near.indices,
        near.poses,
        key_frames.points,
        key_frames.normals,
        geometry.angle_min,
        geometry.beams_per_radian,
        geometry.beams_per_turn,
        np.array(settings.gates),
        settings.scale,
        settings.beams,
        settings.deviation,
        np.array(expected),
        1.0 / np.square(deviations),
    )
    return Aligned(Pose2D(*pose.tolist()), information, ratio, pairs)


# -- correlative search (Olson, ICRA 2009), without its coarse level, as the windows are small -------------------------

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
        correlation.draw(
            self._grid, self._x0, self._y0, self._resolution, self._blur,
            near.indices, near.poses, key_frames.points, key_frames.normals, key_frames.valid,
        )  # fmt: skip

    def search(self, scan: ScanPoints, start: Pose2D, window: Window) -> tuple[Pose2D, float]:
        """Return the pose near a start at which a scan fits the grid best, and its fit from 0 to 1.

        If the scan fits nowhere, the pose is the start.
        """
        pose, fit = correlation.search(
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
