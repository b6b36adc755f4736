"""Joint Gauss-Newton steps of poses from linearised relative constraints, such as pairs of aligned scans."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidGraph
from ppaas.mapping.graph.normal_equations import NormalEquations
from ppaas.planar_poses import PoseArray


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

    def __init__(self) -> None:
        self._equations: NormalEquations | None = None

    def step(self, poses: PoseArray, pairs: LinearisedPairs, damping: float = 1e-6) -> PoseArray:
        """Return the changes (n, 3) to add to x, y, theta of the poses; the first of each connected part is 0.

        Parameters
        ----------
        poses : (n, 3) array
        pairs : LinearisedPairs
        damping : float
            Added to the diagonal of the normal equations.

        Raises
        ------
        InvalidGraph
            The normal equations are not positive definite.
        """
        equations = self._equations
        if equations is None or not equations.has_pattern(len(poses), pairs.first, pairs.second):
            equations = self._equations = None  # frees the old factor before the new one is made
            equations = self._equations = NormalEquations(len(poses), pairs.first, pairs.second)
        equations.linearise(poses, pairs.hessians, pairs.gradients, np.ones(len(pairs.first)))
        changes = equations.step(damping)
        if changes is None:
            raise InvalidGraph("the pairs do not determine the poses: an information matrix is not positive definite")
        return changes
