"""Information of graph edges from that of aligned scans."""

import numpy as np
from numpy.typing import NDArray

from ppaas.planar_poses import rotated, symmetric

STEP_FLOOR = (0.005, 0.005, 0.002)
"""Least standard deviations of an edge between successive key frames [m, m, rad]."""

CLOSURE_FLOOR = (0.03, 0.03, 0.008)
"""Least standard deviations of a loop closure [m, m, rad]."""

CORRELATION = 10.0
"""Factor of the covariance: neighbouring points lie on one surface, and their errors are not independent."""

LEAST = 1e-3
"""Information added to directions that a scan does not determine [1/m², 1/rad²]."""


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
