"""Joint Gauss-Newton steps of poses from linearised relative constraints, such as pairs of aligned scans."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.planar_poses import PoseArray


class LinearisedPairs(NamedTuple):
    """Quadratic models of the error between pairs of nodes, at their current poses.

    With d the change of the pose of ``second`` in the frame of ``first`` (added to x, y, theta), the error of a pair is
    ½ dᵀ H d + gᵀ d.

    Attributes
    ----------
    first, second : (m,) int64 array
        Nodes of each pair; a pair may occur more than once.
    hessians : (m, 3, 3) array
        H, in the frame of the first node.
    gradients : (m, 3) array
        g, in the frame of the first node.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    hessians: NDArray[np.float64]
    gradients: NDArray[np.float64]


class JointSystem:
    """Sparse normal equations of poses; keeps ordering and pattern while the pairs stay the same."""

    def step(self, poses: PoseArray, pairs: LinearisedPairs, damping: float = 1e-6) -> PoseArray:
        """Return the changes (n, 3) to add to x, y, theta of the poses; the first of each connected part is 0.

        Parameters
        ----------
        poses : (n, 3) array
        pairs : LinearisedPairs
        damping : float
            Added to the diagonal of the normal equations.
        """
        raise NotImplementedError
