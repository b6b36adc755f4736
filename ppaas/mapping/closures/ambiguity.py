"""Ambiguity of a match: whether another motion fits nearly as well, as along a corridor or in rooms that look alike."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.closures.branch_and_bound import Excluded, Match, Window, search
from ppaas.mapping.closures.pyramid import LikelihoodPyramid


class Rivalry(NamedTuple):
    """Bounds above which a motion is a rival of the best one.

    Parameters
    ----------
    share : float
        Share of the best score.
    distance : float
        Translations nearer to the best one belong to the same optimum [m] …
    turn : float
        … if their rotations differ by at most this [rad].
    """

    share: float = 0.92
    distance: float = 1.0
    turn: float = 0.3


def rival_match(
    pyramid: LikelihoodPyramid,
    points: NDArray[np.float64],
    window: Window,
    best: Match,
    least: Rivalry,
) -> Match | None:
    """Return the best motion away from the best one, or None if none comes near its score.

    Parameters
    ----------
    pyramid, points, window
        As in the search that found ``best``.
    best : Match
        Best motion.
    least : Rivalry
    """
    return search(pyramid, points, window, least.share * best.score, Excluded(best.motion, least.distance, least.turn))
