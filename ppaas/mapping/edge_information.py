"""Information of graph edges from the information of aligned scans."""

import numpy as np
from numpy.typing import NDArray

from ppaas.planar_poses import rotated, symmetric, upper_triangle

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
