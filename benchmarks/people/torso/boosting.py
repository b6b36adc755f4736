"""Fit of boosted trees to features of few levels, by histograms of gradients."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.perception.torso.models import LEAVES, NODES, Trees
from ppaas.perception.torso.relief import LEVELS

Floats = NDArray[np.float64]


class BoostingParameters(NamedTuple):
    """Parameters of a fit.

    Parameters
    ----------
    trees : int
        Number of trees.
    rate : float
        Factor of each tree.
    ridge : float
        Weight of the squares of the leaves.
    drawn : float
        Share of the features and of the samples that each tree uses.
    lightest : float
        Least weight of the samples of a leaf.
    """

    trees: int = 300
    rate: float = 0.15
    ridge: float = 2.0
    drawn: float = 0.22
    lightest: float = 3.0


_Tree = tuple[NDArray[np.uint16], NDArray[np.uint8], NDArray[np.float32]]


def boost(
    values: NDArray[np.uint8], labels: Floats, parameters: BoostingParameters | None = None, seed: int = 0
) -> Trees:
    """Return trees for the log odds of labels.

    Parameters
    ----------
    values : (n, number of features) uint8 array
        Features, each below `LEVELS`.
    labels : (n,) array
        0 or 1.
    parameters : BoostingParameters, optional
    seed : int
        Seed of the drawn features and samples.
    """
    own, rng = parameters or BoostingParameters(), np.random.default_rng(seed)
    mean = labels.mean()
    bias = float(np.log(mean / (1.0 - mean)))
    odds = np.full(len(labels), bias)
    found = []
    for _ in range(own.trees):
        chance = 1.0 / (1.0 + np.exp(-odds))
        slope, weight = labels - chance, chance * (1.0 - chance)
        rows = np.flatnonzero(rng.random(len(labels)) < np.maximum(own.drawn, 4.0 * weight))
        columns = np.sort(rng.choice(values.shape[1], int(own.drawn * values.shape[1]), replace=False))
        tree = _grow(values[np.ix_(rows, columns)], slope[rows], weight[rows], columns, own)
        found.append(tree)
        odds += _joined([tree], 0.0).odds(values)
    return _joined(found, bias)


def _joined(trees: list[_Tree], bias: float) -> Trees:
    return Trees(
        np.stack([tree[0] for tree in trees]), np.stack([tree[1] for tree in trees]),
        np.stack([tree[2] for tree in trees]), bias,
    )  # fmt: skip


def _grow(
    values: NDArray[np.uint8], slope: Floats, weight: Floats, columns: NDArray[np.int64], own: BoostingParameters
) -> _Tree:
    """Return a tree grown level by level."""
    features, limits = np.zeros(NODES, np.uint16), np.full(NODES, LEVELS - 1, np.uint8)
    node = np.zeros(len(values), np.int64)
    for decision in range(NODES):
        mine = np.flatnonzero(node == decision)
        split = _best_split(values[mine], slope[mine], weight[mine], own) if len(mine) else None
        if split is None:
            node[mine] = 2 * decision + 1
            continue
        column, limit = split
        features[decision], limits[decision] = columns[column], limit
        node[mine] = 2 * decision + 1 + (values[mine, column] > limit)
    leaf = node - NODES
    up, down = (np.bincount(leaf, part, LEAVES) for part in (slope, weight))
    return features, limits, (own.rate * up / (down + own.ridge)).astype(np.float32)


def _best_split(
    values: NDArray[np.uint8], slope: Floats, weight: Floats, own: BoostingParameters
) -> tuple[int, int] | None:
    """Return the column and limit that reduce the loss most; None if none does."""
    count = values.shape[1]
    flat = (values + np.arange(count, dtype=np.int32) * np.int32(LEVELS)).ravel()
    sums = [
        np.bincount(flat, np.repeat(part, count), count * LEVELS).reshape(count, LEVELS).cumsum(axis=1)
        for part in (slope, weight)
    ]
    (up, down), (all_up, all_down) = sums, (slope.sum(), weight.sum())
    gain = up**2 / (down + own.ridge) + (all_up - up) ** 2 / (all_down - down + own.ridge)
    gain[(down < own.lightest) | (all_down - down < own.lightest)] = -np.inf
    best = int(gain.argmax())
    if gain.flat[best] <= all_up**2 / (all_down + own.ridge):
        return None
    return best // LEVELS, best % LEVELS
