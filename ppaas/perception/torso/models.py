"""Models of the upper body: templates, and boosted trees that sum up to log odds.

Source of the trees: Friedman, "Greedy function approximation: a gradient boosting machine", Annals of Statistics 29,
2001.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.perception.torso.patches import COLUMNS, LOWEST, ROW_HEIGHT, ROWS, STEPS

ABOVE, BELOW, LEGS = 4, 20, 9
"""Number of rows above the top of the head, below it, and of the legs above the floor."""

HALF = COLUMNS // 2

SHAPE = (ABOVE + 1 + BELOW + LEGS, HALF, STEPS)
"""Shape of the weights of a posture: rows from top to bottom and rows of the legs, columns inwards, steps."""

TOPS = (np.arange(1.45, 2.01, ROW_HEIGHT), np.arange(1.10, 1.43, ROW_HEIGHT))
"""Heights of the top of the head of people who stand and who sit [m]."""

MIRRORED = np.minimum(np.arange(COLUMNS), COLUMNS - 1 - np.arange(COLUMNS))
"""Column of a template for each column of a patch."""


class TemplateMatch(NamedTuple):
    """Best match of each patch.

    Parameters
    ----------
    odds : (n,) float32 array
        Log odds that it shows a person.
    top : (n,) float32 array
        Height of the top of the head [m].
    """

    odds: NDArray[np.float32]
    top: NDArray[np.float32]


def rows_of(top: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the rows of a patch that a template uses for a head at a height [m], and the template's own rows."""
    head = round((top - LOWEST) / ROW_HEIGHT)
    rows = np.concatenate([np.arange(head + ABOVE, head - BELOW - 1, -1), np.arange(LEGS)])
    used = (rows >= 0) & (rows < ROWS)
    return rows[used], np.flatnonzero(used)


class UpperBody:
    """Templates of people who stand and who sit.

    Parameters
    ----------
    weights : sequence of array
        Weights of each posture, of `SHAPE`.
    biases : sequence of float
        Log odds that each adds.
    """

    def __init__(self, weights: list[NDArray[np.float32]], biases: list[float]) -> None:
        self._tops = np.concatenate(TOPS).astype(np.float32)
        self._weights = np.concatenate(
            [_aligned(weight, top) for weight, tops in zip(weights, TOPS, strict=True) for top in tops], axis=1
        )
        self._biases = np.repeat(np.array(biases, np.float32), [len(tops) for tops in TOPS])

    def match(self, patches: NDArray[np.uint8]) -> TemplateMatch:
        """Return the best match of each patch, (n, `ROWS`, `COLUMNS`) uint8."""
        odds = self.odds(patches)
        best = odds.argmax(axis=1)
        return TemplateMatch(odds[np.arange(len(best)), best], self._tops[best])

    def odds(self, patches: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Return the log odds of patches for each height of `TOPS`, (n, number of heights) float32."""
        cells = ROWS * COLUMNS
        used = patches.reshape(-1, cells) + np.arange(cells) * STEPS
        # Sums of rows instead of a product with a matrix of zeros and ones, for which numpy starts threads.
        odds = np.empty((len(patches), len(self._tops)), np.float32)
        for k, rows in enumerate(used):
            odds[k] = self._weights[rows].sum(axis=0)
        odds += self._biases
        return odds


def _aligned(weight: NDArray[np.float32], top: float) -> NDArray[np.float32]:
    """Return the weights of all cells and steps of a patch for a head at a height, (cells × steps, 1)."""
    all_weights = np.zeros((ROWS, COLUMNS, STEPS), np.float32)
    rows, own = rows_of(top)
    np.add.at(all_weights, rows, weight[own][:, MIRRORED])
    return all_weights.reshape(-1, 1)


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
