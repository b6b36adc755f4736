"""Contradictions: closures of one submap that put it at different places, as in corridors with equal doors."""

import math
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.mapping.closures.candidates import search_window
from ppaas.mapping.closures.closure import Closure, Refusal
from ppaas.mapping.closures.drift import path_covariances
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.graph.pose_graph import Edges

Found = Closure | Refusal

SAME_TURN = 0.1
"""Difference of headings up to which two closures agree in any case [rad]."""


class Contradictions:
    """Comparison of closures of one submap.

    Parameters
    ----------
    poses : (n, 3) array
        Poses of the key frames.
    edges : Edges
        Edges of the pose graph.
    parameters : ClosureParameters
    """

    def __init__(self, poses: NDArray[np.float64], edges: Edges, parameters: ClosureParameters) -> None:
        self._poses, self._edges, self._parameters = poses, edges, parameters

    def with_best(self, best: Closure, others: Iterable[Found]) -> Iterator[Found]:
        """Yield the matches that put the submap at a place which drift between the older submaps does not explain.

        Parameters
        ----------
        best : Closure
            Closure with the largest score.
        others : iterable of Closure and Refusal
        """
        covariances = None
        for other in others:
            if other.motion is None:
                continue
            apart = self._difference(best, other.motion)
            if math.hypot(apart.x, apart.y) < self._parameters.ambiguous_distance and abs(apart.theta) < SAME_TURN:
                continue
            if covariances is None:
                model = self._parameters.drift
                covariances, _ = path_covariances(self._poses, self._edges, best.target.middle, model)
            if not self._explains(covariances[other.target.middle], apart):
                yield other

    def _difference(self, best: Closure, motion: Pose2D) -> Pose2D:
        """Return the difference of the poses of one key frame by two matches, in the axes of the map."""
        pose = Pose2D(*self._poses[best.source.middle].tolist())
        one, two = best.motion @ pose, motion @ pose
        return Pose2D(two.x - one.x, two.y - one.y, wrap_angle(two.theta - one.theta))

    def _explains(self, covariance: NDArray[np.float64], apart: Pose2D) -> bool:
        """Return whether a difference of poses is within the window of a covariance."""
        (x, y, turn), angle = search_window(covariance, self._parameters)
        c, s = math.cos(angle), math.sin(angle)
        along, across = c * apart.x + s * apart.y, c * apart.y - s * apart.x
        return abs(along) <= x and abs(across) <= y and abs(apart.theta) <= turn
