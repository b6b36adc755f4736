"""Pairs of legs: joins the legs of a scan to people."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STANDING, STRIDING = 0.4, 0.8
"""Distance between the legs of a person who stands, and the largest one of a person who walks [m]."""

STRIDE_SPREAD = 0.15
"""Standard deviation of the distance beyond `STANDING` [m]."""

AROUND = 0.7
"""Distance from the middle of two legs within which further legs speak against a person: tables have four [m]."""

LIKE = -0.5
"""Evidence from which a segment counts as like a leg."""

BONUS, ALONE = 1.0, -3.0
"""Evidence of a second leg, and of a leg alone, whose second one is hidden or not a leg at all."""


class Legs(NamedTuple):
    """One or two legs of a person.

    Parameters
    ----------
    x, y : float
        Middle of the legs [m].
    evidence : float
        Logarithm of the odds that they belong to a person.
    apart : float
        Distance between the two legs [m]; 0 for one leg, or for two that are one segment.
    both : bool
        Whether both legs are seen.
    """

    x: float
    y: float
    evidence: float
    apart: float
    both: bool


def people_of(centres: Floats, legs: Floats, motion: Floats) -> list[Legs]:
    """Join legs to people, the best pairs first; each leg belongs to one person.

    Parameters
    ----------
    centres : (n, 2) array
        Centres of the legs [m].
    legs : (n,) array
        Evidence that each is a leg.
    motion : (n,) array
        Evidence that it has moved.
    """
    pairs = _pairs(centres, legs + motion)
    used: set[int] = set()
    found = []
    for evidence, i, k in pairs:
        if i in used or k in used:
            continue
        middle = 0.5 * (centres[i] + centres[k])
        others = _others(middle, centres, legs, motion, (i, k))
        if evidence - others <= max(legs[i] + motion[i], legs[k] + motion[k]) + ALONE:
            continue
        used |= {i, k}
        x, y = middle.tolist()
        found.append(Legs(x, y, evidence - others, float(np.hypot(*(centres[i] - centres[k]))), True))
    for i in sorted(set(range(len(centres))) - used):
        x, y = centres[i].tolist()
        found.append(Legs(x, y, float(legs[i] + motion[i]) + ALONE, 0.0, False))
    return found


def _pairs(centres: Floats, evidence: Floats) -> list[tuple[float, int, int]]:
    """Return the pairs that may be the legs of one person, with their evidence, the best first."""
    i, k = np.triu_indices(len(centres), 1)
    apart = np.hypot(*(centres[i] - centres[k]).T)
    near = apart <= STRIDING
    i, k, apart = i[near], k[near], apart[near]
    odds = evidence[i] + evidence[k] + BONUS - (np.maximum(apart - STANDING, 0.0) / STRIDE_SPREAD) ** 2
    # Of pairs that are as likely, the nearer legs belong to one person.
    order = np.argsort(-(odds - apart), kind="stable")
    return list(zip(odds[order].tolist(), i[order].tolist(), k[order].tolist(), strict=True))


def _others(middle: Floats, centres: Floats, legs: Floats, motion: Floats, pair: tuple[int, int]) -> float:
    """Return the evidence against a pair of further legs around it that do not move."""
    around = (np.hypot(*(centres - middle).T) < AROUND) & (legs > LIKE) & (motion <= 0.0)
    around[list(pair)] = False
    return float(around.sum())
