"""Boosted trees, which sum up to log odds (Friedman, "Greedy function approximation: a gradient boosting machine",
Annals of Statistics 29, 2001)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

DEPTH = 3
"""Number of decisions of a tree from its root to a leaf."""

NODES, LEAVES = (1 << DEPTH) - 1, 1 << DEPTH
"""Numbers of decisions and of leaves of a tree."""


class Trees(NamedTuple):
    """Binary trees of decisions; the children of decision k are 2 k + 1 and 2 k + 2.

    Parameters
    ----------
    features : (n, `NODES`) uint16 array
        Feature of each decision.
    limits : (n, `NODES`) uint8 array
        Larger values of the feature take the second branch.
    leaves : (n, `LEAVES`) float32 array
        Log odds that each leaf adds.
    bias : float
        Log odds without trees.
    """

    features: NDArray[np.uint16]
    limits: NDArray[np.uint8]
    leaves: NDArray[np.float32]
    bias: float

    def odds(self, values: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Return the log odds of samples, (n, number of features) uint8."""
        trees = np.arange(len(self.features))[None, :]
        node = np.zeros((len(values), len(self.features)), np.int64)
        for _ in range(DEPTH):
            feature = self.features[trees, node]
            above = np.take_along_axis(values, feature.astype(np.int64), axis=1) > self.limits[trees, node]
            node = 2 * node + 1 + above
        odds: NDArray[np.float32] = self.leaves[trees, node - NODES].sum(axis=1) + np.float32(self.bias)
        return odds
