"""Key frames as nodes of a pose graph, and the information of its edges from the information of aligned scans."""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.planar_poses import PoseArray, relative, rotated, symmetric, upper_triangle

# -- information of edges ----------------------------------------------------------------------------------------------

STEP_FLOOR = (0.005, 0.005, 0.002)
"""Least standard deviations of an edge between successive key frames [m, m, rad]."""

CLOSURE_FLOOR = (0.03, 0.03, 0.008)
"""Least standard deviations of a loop closure [m, m, rad]."""

CORRELATION = 10.0
"""Factor of the covariance: neighbouring points lie on one surface, and their errors are not independent."""

LEAST = 1e-3
"""Information added to directions that a scan does not determine [1/m², 1/rad²]."""

DETERMINED = 0.1
"""Information of the position along every axis that an edge has at least if it determines the position [1/m²]."""


def edge_information(
    measurements: NDArray[np.float64],
    information: NDArray[np.float64],
    floor: tuple[float, float, float],
    correlation: float = CORRELATION,
) -> NDArray[np.float64]:
    """Return the information of edges in the frames of their first nodes.

    Parameters
    ----------
    measurements : (..., 3) array
        Pose of each edge's second node in the frame of its first one.
    information : (..., 6) array
        Information of that pose in the frame of the second node, as `ppaas.mapping.alignment.Aligned` has it.
    floor : tuple of float
        Least standard deviations: `STEP_FLOOR` or `CLOSURE_FLOOR` [m, m, rad].
    correlation : float
        Factor of the covariance.

    Returns
    -------
    (..., 3, 3) float64 array
    """
    covariance = np.linalg.inv(symmetric(information) + LEAST * np.eye(3)) * correlation + np.diag(np.square(floor))
    found: NDArray[np.float64] = np.asarray(np.linalg.inv(rotated(covariance, measurements[..., 2])), np.float64)
    return found


def weakest_information(information: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the information (…) of positions in the direction in which it is least [1/m²], of (…, 6) arrays."""
    xx, xy, yy = information[..., 0], information[..., 1], information[..., 3]
    weakest: NDArray[np.float64] = (xx + yy) / 2.0 - np.hypot((xx - yy) / 2.0, xy)
    return weakest


def forgetting(information: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the projections (…, 3, 3) that remove the direction in which scans determine the position least.

    Along a corridor, the noise of the normals looks like information. As in Zhang, Kaess and Singh, *On Degeneracy of
    Optimization-based State Estimation Problems* (ICRA 2016).

    Parameters
    ----------
    information : (…, 6) array
        Information xx, xy, xt, yy, yt, tt.
    """
    xx, xy, yy = information[..., 0], information[..., 1], information[..., 3]
    # The axis of the smaller eigenvalue of the 2 × 2 block of the position.
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy) + 0.5 * np.pi
    axis = np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    kept = np.tile(np.eye(3), (*angle.shape, 1, 1))
    kept[..., :2, :2] -= axis[..., :, np.newaxis] * axis[..., np.newaxis, :]
    return kept


def determines_position(information: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether edges (m,) with an information (m, 3, 3) determine the position, not only beside a corridor."""
    determined: NDArray[np.bool_] = weakest_information(upper_triangle(information)) >= DETERMINED
    return determined


# -- key frames as nodes -----------------------------------------------------------------------------------------------


def append_key_frame(graph: PoseGraph, frames: KeyFrames) -> PoseArray:
    """Append the last key frame to a graph, and return its pose in the frame of the one before, zeros for the first.

    Parameters
    ----------
    graph : PoseGraph
        Modified: it has a node for each earlier key frame.
    frames : KeyFrames

    Returns
    -------
    (3,) array
        x, y [m], theta [rad].
    """
    node = graph.add_node(frames.poses[-1])
    step = np.zeros(3)
    if node:
        step = relative(frames.poses[node - 1], frames.poses[node])
        information = edge_information(step, frames.information[node], STEP_FLOOR)
        graph.add_edge(node - 1, node, step, information, EdgeKind.ODOMETRY)
    return step


def append_lost(graph: PoseGraph, frames: KeyFrames) -> PoseArray:
    """Append the last key frame to a graph as the first one of a part that no edge connects; return zeros (3,)."""
    graph.add_node(frames.poses[-1])
    return np.zeros(3)


def append_placed(graph: PoseGraph, frames: KeyFrames, nearest: int) -> None:
    """Append the last key frame to a graph, with an edge from another one that it was aligned with.

    Parameters
    ----------
    graph : PoseGraph
        Modified: it has a node for each earlier key frame.
    frames : KeyFrames
    nearest : int
        Index of the other key frame.
    """
    node = graph.add_node(frames.poses[-1])
    step = relative(frames.poses[nearest], frames.poses[node])
    information = edge_information(step, frames.information[node], STEP_FLOOR)
    graph.add_edge(nearest, node, step, information, EdgeKind.ODOMETRY)
