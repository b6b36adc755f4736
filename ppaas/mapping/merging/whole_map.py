"""Search for a place in a whole map: all positions and all headings, coarse first, then fine around the best one."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.branch_and_bound import Excluded, Window, search
from ppaas.mapping.closures.pyramid import Blur, LikelihoodPyramid, build_pyramid
from ppaas.mapping.merging.parameters import MergeParameters
from ppaas.planar_poses import PoseArray

BEYOND = 5.0
"""Distance around the key frames of the map up to which places are searched [m]."""

APART, APART_TURN = 1.5, 0.3
"""Distance and angle beyond which a second place is another one than the first [m, rad]."""

NEARLY = 0.85
"""Share of the score of the best place that a second one needs."""

FINE = Window(0.6, 0.6, 0.06)
"""Window around a place of the coarse search."""


class WholeMap:
    """All points of a mapping, ready for searches.

    Parameters
    ----------
    points : (n, 2) array
        Points of all scans in the map frame [m].
    poses : (k, 3) array
        Poses of the key frames in the map frame; at least one. Places are searched around them.
    parameters : MergeParameters
    """

    def __init__(self, points: NDArray[np.float64], poses: PoseArray, parameters: MergeParameters) -> None:
        low, high = poses[:, :2].min(axis=0) - BEYOND, poses[:, :2].max(axis=0) + BEYOND
        self._middle, half = (low + high) / 2.0, (high - low) / 2.0
        self._least = parameters.least_score
        self._window = Window(float(half[0]), float(half[1]), math.pi, parameters.heading_step)
        x, y = np.abs(points - self._middle).max(axis=0, initial=0.0).tolist()
        reach = (x + 1.0, y + 1.0)
        levels = self._window.levels(parameters.resolution)
        self._coarse = self._pyramid(points, reach, parameters.resolution, levels)
        self._fine = self._pyramid(points, reach, parameters.fine_resolution, 1)

    def places(self, points: NDArray[np.float64]) -> list[tuple[Pose2D, float]]:
        """Return the best places of some points in the map, and their scores: two, one or none.

        Parameters
        ----------
        points : (n, 2) array
            Points around the origin of any frame [m].

        Returns
        -------
        list of (Pose2D, float)
            Poses of that frame in the map frame, with scores from 0 to 1, the best one first.
        """
        best = search(self._coarse, points, self._window, self._least)
        if best is None:
            return []
        apart = Excluded(best.motion, APART, APART_TURN)
        second = search(self._coarse, points, self._window, max(self._least, NEARLY * best.score), apart)
        found = (self._finer(points, match.motion) for match in (best, second) if match is not None)
        # The coarse search may find the better one second.
        return sorted((place for place in found if place is not None), key=lambda place: -place[1])

    def _finer(self, points: NDArray[np.float64], coarse: Pose2D) -> tuple[Pose2D, float] | None:
        """Return a place of the coarse search at the finer resolution, in the map frame."""
        c, s = math.cos(coarse.theta), math.sin(coarse.theta)
        turned = points @ np.array(((c, s), (-s, c)))
        shifted = replace(self._fine, corner=self._fine.corner - (coarse.x, coarse.y))
        match = search(shifted, turned, FINE)
        if match is None:
            return None
        x, y, turn = match.motion
        place = Pose2D(coarse.x + x + self._middle[0], coarse.y + y + self._middle[1], coarse.theta + turn)
        return place, match.score

    def _pyramid(
        self, points: NDArray[np.float64], reach: tuple[float, float], resolution: float, levels: int
    ) -> LikelihoodPyramid:
        return build_pyramid(points - self._middle, reach, Blur(resolution, resolution), levels)
