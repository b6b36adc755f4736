"""Normal equations of the poses of a graph, with a fixed node in each connected part, and joint steps by them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidGraph
from ppaas.mapping.graph.block_cholesky import BlockCholesky
from ppaas.mapping.graph.kernels.edges import add_edges, connected_parts
from ppaas.planar_poses import PoseArray

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


class NormalEquations:
    """Equations H d = −b for the changes d of poses; the pattern of H and the elimination are planned once.

    The given nodes are fixed, and the first node of each connected part that has none of them.

    Parameters
    ----------
    count : int
        Number of nodes.
    first, second : (m,) array
        Nodes of the edges; several edges may connect the same nodes.
    fixed : sequence of int
        Nodes that keep their poses.
    """

    def __init__(self, count: int, first: Ints, second: Ints, fixed: Sequence[int] = ()) -> None:
        self._count, self._first, self._second = count, first.copy(), second.copy()
        parts = connected_parts(count, self._first, self._second)
        self._free = np.flatnonzero(~_held(parts, np.array(fixed, np.int64)))
        self._rows = np.full(count, -1, np.int64)
        self._rows[self._free] = np.arange(len(self._free))
        lower, upper, self._slots = self._pattern()
        self.factor = BlockCholesky(len(self._free), lower, upper)
        self._diagonal = np.zeros((len(self._free), 3, 3))
        self._off_diagonal = np.zeros((len(lower), 3, 3))
        self._right = np.zeros((len(self._free), 3))

    def has_pattern(self, count: int, first: Ints, second: Ints) -> bool:
        """Return whether these equations are for this number of nodes and these edges."""
        return count == self._count and np.array_equal(first, self._first) and np.array_equal(second, self._second)

    def linearise(self, poses: PoseArray, hessians: Floats, gradients: Floats, weights: Floats) -> None:
        """Set up the equations.

        Parameters
        ----------
        poses : (n, 3) array
        hessians, gradients : (m, 3, 3), (m, 3) array
            Second and first derivatives of half the squared error of each edge by the relative pose of its nodes.
        weights : (m,) array
            Factors of both.
        """
        for array in (self._diagonal, self._off_diagonal, self._right):
            array[:] = 0.0
        edges = (self._first, self._second, hessians, gradients, weights, self._rows, self._slots)
        add_edges(poses, *edges, self._diagonal, self._off_diagonal, self._right)

    def step(self, damping: float, relative_damping: float = 0.0) -> PoseArray | None:
        """Return the changes (n, 3) of the poses, or None if the damped H is not positive definite.

        Parameters
        ----------
        damping : float
            Added to the diagonal of H.
        relative_damping : float
            Share of the diagonal of H that is added to it (Marquardt).
        """
        added = damping + relative_damping * np.diagonal(self._diagonal, axis1=1, axis2=2)
        if not self.factor.factorise(self._diagonal, self._off_diagonal, added):
            return None
        return self.step_again()

    def step_again(self) -> PoseArray:
        """Return the changes (n, 3) of the poses with the factor of the last `step`."""
        changes = np.zeros((self._count, 3))
        changes[self._free] = self.factor.solve(-self._right)
        return changes

    def _pattern(self) -> tuple[Ints, Ints, Ints]:
        """Return the pairs of free nodes that edges connect, and the slot of each edge."""
        first, second = self._rows[self._first], self._rows[self._second]
        lower, upper = np.minimum(first, second), np.maximum(first, second)
        free = lower >= 0
        keys, inverse = np.unique(lower[free] * len(self._free) + upper[free], return_inverse=True)
        slots = np.zeros(len(first), np.int64)
        slots[free] = inverse
        return keys // max(1, len(self._free)), keys % max(1, len(self._free)), np.where(first <= second, slots, ~slots)


def _held(parts: Ints, fixed: Ints) -> NDArray[np.bool_]:
    """Return which nodes (n,) are fixed: the given ones, and the first of each part without them.

    ``parts`` names the smallest node of the connected part of each node, (n,).
    """
    nodes = np.arange(len(parts))
    held: NDArray[np.bool_] = (parts == nodes) & ~np.isin(parts, parts[fixed])
    held[fixed] = True
    return held


# -- joint steps of poses from linearised relative constraints ---------------------------------------------------------


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
