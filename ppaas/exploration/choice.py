"""Choice among approaches to frontiers: short paths and large frontiers first, with hysteresis."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.exploration.approaches import Approach
from ppaas.exploration.parameters import ChoiceParameters

SAME = 0.5
"""Distance from a place up to which a frontier is still there [m]."""


def same_frontier(
    approaches: Sequence[Approach], points: Sequence[NDArray[np.float64]], seen: NDArray[np.float64], within: float
) -> Approach | None:
    """Return the approach whose frontier is nearest to a place, if it is near enough.

    Parameters
    ----------
    approaches : sequence of Approach
    points : sequence of (n, 2) array
        Cells of the frontier of each, x, y [m].
    seen : (2,) array
        Place on an earlier frontier, x, y [m].
    within : float
        Largest distance of the place from a cell [m].
    """
    nearest = [float(np.hypot(*(cells - seen).T).min()) for cells in points]
    best = int(np.argmin(nearest)) if nearest else -1
    return approaches[best] if best >= 0 and nearest[best] <= within else None


NOBODY: NDArray[np.float64] = np.empty((0, 2))
"""Positions of no other robot."""


def score(approach: Approach, parameters: ChoiceParameters, others: NDArray[np.float64] = NOBODY) -> float:
    """Return the cost of the path less the gain of the frontier [m]; the lowest score is the best.

    Robots of one map spread: a frontier costs more if one of the others (n, 2), x, y [m], is nearer to it.
    """
    gain = min(approach.size, parameters.largest_gain)
    left = bool((np.hypot(*(others - approach.seen).T) < approach.distance).any())
    return (
        parameters.potential_scale * approach.distance
        - parameters.gain_scale * gain
        + (parameters.others_penalty if left else 0.0)
    )


def choose(
    approaches: Sequence[Approach],
    parameters: ChoiceParameters,
    current: Approach | None = None,
    others: NDArray[np.float64] = NOBODY,
) -> Approach | None:
    """Return the best approach; None if there is none.

    Parameters
    ----------
    approaches : sequence of Approach
    parameters : ChoiceParameters
    current : Approach, optional
        The one among them that the robot drives to. Another must be better by the hysteresis.
    others : (n, 2) array
        Positions of other robots that explore the same map, x, y [m].
    """
    if not approaches:
        return None
    scores = [score(each, parameters, others) for each in approaches]
    best = approaches[int(np.argmin(scores))]
    if current is not None and min(scores) > score(current, parameters, others) - parameters.hysteresis:
        return current
    return best
