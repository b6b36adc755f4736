"""Fit of the torso detector's templates: logistic regression of patches with the height of the head as latent variable.

As in latent SVMs (Felzenszwalb et al., "Object detection with discriminatively trained part based models", PAMI 2010),
patches without a person take part with the heights at which the last templates match them best.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.perception.torso.models import MIRRORED, SHAPE, TOPS, UpperBody, rows_of

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
