"""Fits of the torso detector: boosted trees, and templates by logistic regression.

The height of the head is the latent variable of the templates. The trees have features of few levels and are fitted by
histograms of gradients. As in latent SVMs (Felzenszwalb et al., "Object detection with discriminatively trained part
based models", PAMI 2010), patches without a person take part with the heights at which the last templates match them
best.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.perception.torso.models import LEAVES, MIRRORED, NODES, SHAPE, TOPS, Trees, UpperBody, rows_of
from ppaas.perception.torso.relief import LEVELS

Floats = NDArray[np.float64]


# -- fit of boosted trees to features of few levels, by histograms of gradients ----------------------------------------


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


# -- fit of the torso detector's templates -----------------------------------------------------------------------------

STEPS = SHAPE[2]

ROUNDS, ITERATIONS = 4, 150
"""Number of fits, and of iterations of each."""

RIDGE = 3.0
"""Weight of the squares of the weights."""

RANDOM, HARDEST = 5_000, 12_000
"""Numbers of patches without a person that take part in a fit: drawn at random, and those most like people."""

CHUNKS = 64
"""Number of parts in which patches are scored."""

SITS = 1.43
"""Height of the head below which people sit [m]."""


class Samples(NamedTuple):
    """Patches to learn from.

    Parameters
    ----------
    patches : (n, rows, columns) uint8 array
    tops : (n,) array
        Height of the head of the person it shows; 0 for none [m].
    """

    patches: NDArray[np.uint8]
    tops: NDArray[np.float64]


class Fitted(NamedTuple):
    """Fitted templates, one a posture: weights of `SHAPE`, and biases."""

    weights: list[NDArray[np.float32]]
    biases: list[float]

    def templates(self) -> UpperBody:
        """Return the templates."""
        return UpperBody(self.weights, self.biases)


def fit(samples: Samples, rounds: int = ROUNDS) -> Fitted:
    """Return templates fitted to samples, each person at the height of its head."""
    fitted: Fitted | None = None
    for _ in range(rounds):
        fitted = Fitted(*zip(*(_fit_posture(samples, k, fitted) for k in range(len(TOPS))), strict=True))  # type: ignore[arg-type]
    assert fitted is not None
    return fitted


def _fit_posture(samples: Samples, posture: int, last: Fitted | None) -> tuple[NDArray[np.float32], float]:
    people = np.flatnonzero((samples.tops > 0.0) & ((samples.tops < SITS) == (posture == 1)))
    tops = TOPS[posture]
    aligned = [_features(samples.patches[k], tops[np.abs(tops - samples.tops[k]).argmin()]) for k in people]
    aligned += [_features(samples.patches[k], top) for k, top in _nobody(samples, posture, last)]
    labels = np.zeros(len(aligned))
    labels[: len(people)] = 1.0
    weights = _regression(aligned, labels)
    return weights[:-1].reshape(SHAPE).astype(np.float32), float(weights[-1])


def _nobody(samples: Samples, posture: int, last: Fitted | None) -> list[tuple[int, float]]:
    """Return patches that show nobody, with the height of a head: the most alike, and some at random."""
    rng, tops = np.random.default_rng(posture), TOPS[posture]
    others = np.flatnonzero(samples.tops == 0.0)
    drawn = rng.choice(others, min(RANDOM, len(others)), replace=False)
    chosen = [(int(k), float(top)) for k, top in zip(drawn, rng.choice(tops, len(drawn)), strict=True)]
    if last is None:
        return chosen
    templates, first = last.templates(), sum(map(len, TOPS[:posture]))
    odds = np.concatenate([templates.odds(samples.patches[part]) for part in np.array_split(others, CHUNKS)])
    odds = odds[:, first : first + len(tops)]
    best = odds.argmax(axis=1)
    hardest = np.argsort(-odds.max(axis=1))[:HARDEST]
    return chosen + [(int(others[k]), float(tops[best[k]])) for k in hardest]


def _features(patch: NDArray[np.uint8], top: float) -> NDArray[np.int64]:
    """Return the indices of the weights that a patch uses."""
    rows, own = rows_of(top)
    columns = MIRRORED[None, :]
    return ((own[:, None] * SHAPE[1] + columns) * STEPS + patch[rows]).ravel()


def _regression(aligned: list[NDArray[np.int64]], labels: NDArray[np.float64]) -> NDArray[np.float64]:
    from scipy.optimize import minimize  # noqa: PLC0415
    from scipy.sparse import csr_matrix  # noqa: PLC0415

    ends = np.cumsum([0, *map(len, aligned)])
    shape = len(aligned), int(np.prod(SHAPE))
    features = csr_matrix((np.ones(ends[-1], np.float32), np.concatenate(aligned), ends), shape)
    transposed, sign = features.T.tocsr(), np.where(labels > 0.0, 1.0, -1.0)

    def loss(weights: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        margin = sign * (features @ weights[:-1] + weights[-1])
        slope = -sign / (1.0 + np.exp(np.clip(margin, -50.0, 50.0)))
        value = np.logaddexp(0.0, -margin).sum() + 0.5 * RIDGE * weights[:-1] @ weights[:-1]
        return float(value), np.append(transposed @ slope + RIDGE * weights[:-1], slope.sum())

    start = np.zeros(shape[1] + 1)
    return np.asarray(minimize(loss, start, jac=True, method="L-BFGS-B", options={"maxiter": ITERATIONS}).x)
