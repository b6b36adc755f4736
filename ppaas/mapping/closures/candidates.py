"""Candidates: the older submaps that the latest one may overlap, each with a window shaped by the covariance.

That is the drift along the shortest path of the pose graph. The covariance along one path bounds the true one from
above, as other paths only add information (Bosse et al., *SLAM in Large-scale Cyclic Environments using the Atlas
Framework*, IJRR 2004). Errors of the heading move all that lies beyond, so the covariance is long across the path and
narrow along it.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.branch_and_bound import MotionWindow
from ppaas.mapping.closures.kernels.drift import path_moments
from ppaas.mapping.closures.parameters import ClosureParameters, DriftModel
from ppaas.mapping.closures.submaps import Submap, travelled
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges
from ppaas.mapping.key_frame_graph import determines_position

# -- drift: uncertainty of older key frames relative to the latest -----------------------------------------------------

CLOSURE_LENGTH = 0.2
"""Distance travelled that has the uncertainty of a closure [m]."""

LEAST_LENGTH = 1e-3
"""Least length of an edge [m]."""


def path_covariances(
    poses: NDArray[np.float64], edges: Edges, root: int, model: DriftModel
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the uncertainty of one node's pose, given each other node's pose.

    Parameters
    ----------
    poses : (n, 3) array
        Poses of the nodes.
    edges : Edges
        Edges of the graph. Closures that leave the position open in a direction, as along a corridor, are left
        out.
    root : int
        The node.
    model : DriftModel

    Returns
    -------
    (n, 3, 3) array
        Covariance of the root's x, y, theta in the map frame, if the other node is at its pose; infinite on the
        diagonal without a path.
    (n,) array
        Distance travelled along the path [m].
    """
    edges = edges.take((edges.kinds != EdgeKind.CLOSURE) | determines_position(edges.information))
    starts, neighbours, lengths, signs = _adjacency(len(poses), edges)
    moments = path_moments(root, starts, neighbours, lengths, signs, np.ascontiguousarray(poses[:, :2]))
    distance = moments[:, 0].copy()
    apart = np.isinf(distance)
    moments[apart] = 0.0
    covariances = _covariances(moments, poses[root, :2], model)
    covariances[apart] = np.diag(np.full(3, np.inf))
    return covariances, distance


def _adjacency(
    n: int, edges: Edges
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Return each node's edges in compressed rows: first edge of a node, other node, length and sign."""
    closure = edges.kinds == EdgeKind.CLOSURE
    length = np.where(closure, CLOSURE_LENGTH, np.maximum(travelled(edges.measurements), LEAST_LENGTH))
    sign = np.where(closure, 0.0, np.sign(edges.second - edges.first))
    ends = np.concatenate((edges.first, edges.second))
    order = np.argsort(ends, kind="stable")
    starts = np.zeros(n + 1, np.int64)
    np.cumsum(np.bincount(ends, minlength=n), out=starts[1:])
    others = np.concatenate((edges.second, edges.first))[order]
    return starts, others, np.tile(length, 2)[order], np.concatenate((sign, -sign))[order]


def _covariances(moments: NDArray[np.float64], at: NDArray[np.float64], model: DriftModel) -> NDArray[np.float64]:
    """Return covariances (n, 3, 3) at a position (2,) from the sums along the paths."""
    length, sx, sy, sxx, sxy, syy, signed, mx, my = moments.T
    x, y = at
    # Levers from the steps to the position: Σ l (p − q)(p − q)ᵀ; an error of the heading moves across the lever.
    lxx = length * x * x - 2.0 * x * sx + sxx
    lxy = length * x * y - x * sy - y * sx + sxy
    lyy = length * y * y - 2.0 * y * sy + syy
    walk = np.zeros((len(moments), 3, 3))
    walk[:, 0, 0], walk[:, 0, 1], walk[:, 1, 1] = lyy, -lxy, lxx
    walk[:, 0, 2], walk[:, 1, 2] = -(length * y - sy), length * x - sx
    walk[:, 2, 2] = length
    walk[:, 1, 0], walk[:, 2, 0], walk[:, 2, 1] = walk[:, 0, 1], walk[:, 0, 2], walk[:, 1, 2]
    # A systematic error adds the levers instead of their squares.
    bias = np.stack((-(signed * y - my), signed * x - mx, signed), axis=-1)
    own = model.translation_walk**2 * length + (model.translation_bias * length) ** 2
    covariances: NDArray[np.float64] = model.heading_walk**2 * walk
    covariances += model.heading_bias**2 * bias[:, :, None] * bias[:, None, :]
    covariances[:, 0, 0] += own
    covariances[:, 1, 1] += own
    return covariances


# -- candidates --------------------------------------------------------------------------------------------------------

OVERLAP = 2.0
"""Distance between key frames within which two submaps are expected to show the same place [m]."""


class SubmapCandidate(NamedTuple):
    """Older submap to search.

    Parameters
    ----------
    target : int
        Index of the older submap.
    frame : Pose2D
        Frame of the search in the map frame: at the middle of the latest submap, x along the longest axis of the
        covariance.
    window : MotionWindow
        Window of motions in that frame.
    wide : bool
        Whether the window is so wide that a match may be ambiguous.
    far : float
        Distance from the estimated place, as a share of the largest at which the submaps may still overlap.
    """

    target: int
    frame: Pose2D
    window: MotionWindow
    wide: bool
    far: float


def find_candidates(
    poses: NDArray[np.float64], edges: Edges, submaps: list[Submap], of: int, parameters: ClosureParameters
) -> list[SubmapCandidate]:
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
) -> SubmapCandidate | None:
    """Return the candidate for one older submap, or None if it is out of reach."""
    (x, y, turn), angle = search_window(covariance, parameters)
    # Nearest key frame of the older submap, in the axes of the window.
    dx, dy = (poses[:, :2] - centre).T
    c, s = math.cos(angle), math.sin(angle)
    along, across = c * dx + s * dy, c * dy - s * dx
    far = float(np.hypot(along / (x + OVERLAP), across / (y + OVERLAP)).min())
    if far >= 1.0:
        return None
    window = MotionWindow(x, y, turn, parameters.heading_step)
    return SubmapCandidate(
        target, Pose2D(float(centre[0]), float(centre[1]), angle), window, x > parameters.wide_window, far
    )


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
