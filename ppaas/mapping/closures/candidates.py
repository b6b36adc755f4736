"""Candidates: the older submaps that the latest one may overlap, each with a window shaped by the covariance."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.branch_and_bound import Window
from ppaas.mapping.closures.drift import path_covariances
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import Edges

OVERLAP = 2.0
"""Distance between key frames within which two submaps are expected to show the same place [m]."""


class Candidate(NamedTuple):
    """Older submap to search.

    Parameters
    ----------
    target : int
        Index of the older submap.
    frame : Pose2D
        Frame of the search in the map frame: at the middle of the latest submap, x along the longest axis of the
        covariance.
    window : Window
        Window of motions in that frame.
    wide : bool
        Whether the window is so wide that a match may be ambiguous.
    far : float
        Distance from the estimated place, as a share of the largest at which the submaps may still overlap.
    """

    target: int
    frame: Pose2D
    window: Window
    wide: bool
    far: float


def find_candidates(
    poses: NDArray[np.float64], edges: Edges, submaps: list[Submap], of: int, parameters: ClosureParameters
) -> list[Candidate]:
    """Return the older submaps that one may overlap, the most probable first.

    Parameters
    ----------
    poses : (n, 3) array
        Poses of the key frames.
    edges : Edges
        Edges of the pose graph of the key frames.
    submaps : list of Submap
    of : int
        Index of the submap that is searched in the older ones.
    parameters : ClosureParameters
    """
    submap, older = submaps[of], submaps[: max(of - parameters.fewest_submaps_between, 0)]
    if not older:
        return []
    covariances, _ = path_covariances(poses, edges, submap.middle, parameters.drift)
    centre = poses[submap.first : submap.end, :2].mean(axis=0)
    found = [
        candidate
        for target, other in enumerate(older)
        if (
            candidate := _candidate(
                target, poses[other.first : other.end], covariances[other.middle], centre, parameters
            )
        )
    ]
    found.sort(key=lambda candidate: candidate.far)
    return found


def _candidate(
    target: int,
    poses: NDArray[np.float64],
    covariance: NDArray[np.float64],
    centre: NDArray[np.float64],
    parameters: ClosureParameters,
) -> Candidate | None:
    """Return the candidate for one older submap, or None if it is out of reach."""
    (x, y, turn), angle = search_window(covariance, parameters)
    # Nearest key frame of the older submap, in the axes of the window.
    dx, dy = (poses[:, :2] - centre).T
    c, s = math.cos(angle), math.sin(angle)
    along, across = c * dx + s * dy, c * dy - s * dx
    far = float(np.hypot(along / (x + OVERLAP), across / (y + OVERLAP)).min())
    if far >= 1.0:
        return None
    window = Window(x, y, turn, parameters.heading_step)
    return Candidate(target, Pose2D(float(centre[0]), float(centre[1]), angle), window, x > parameters.wide_window, far)


def search_window(
    covariance: NDArray[np.float64], parameters: ClosureParameters
) -> tuple[tuple[float, float, float], float]:
    """Return the window of a covariance.

    Parameters
    ----------
    covariance : (3, 3) array
        Covariance of x, y, theta in the map frame.
    parameters : ClosureParameters

    Returns
    -------
    (float, float, float)
        Half sizes along the long and the short axis, and of the rotation [m, m, rad].
    float
        Direction of the long axis [rad].
    """
    most = (
        parameters.loop_search_maximum_distance,
        parameters.loop_search_maximum_distance,
        parameters.loop_search_maximum_heading,
    )
    if not np.isfinite(covariance).all():
        return most, 0.0
    values, vectors = np.linalg.eigh(covariance[:2, :2])
    deviations = np.sqrt(np.maximum((values[1], values[0], covariance[2, 2]), 0.0))
    least = (parameters.least_window, parameters.least_window, parameters.least_window_heading)
    half = np.minimum(least + parameters.window_deviations * deviations, most)
    return (float(half[0]), float(half[1]), float(half[2])), math.atan2(vectors[1, 1], vectors[0, 1])
