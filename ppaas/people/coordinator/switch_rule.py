"""Step 5: the rule by which one robot takes a person over from another."""

import math
from collections.abc import Sequence
from itertools import pairwise


def takes_over(current: float, other: Sequence[float], samples: int) -> bool:
    """Return whether robot R′ takes the followed person over from robot R.

    The paper: "switch to R′ only if R′'s cost is strictly decreasing over the observed history and smaller than R's".

    Parameters
    ----------
    current : float
        Cost of the shortest path from R to the person now.
    other : sequence of float
        Costs of R′ over the observed history, the newest last.
    samples : int
        Length of the history; with fewer costs R keeps the person.
    """
    if len(other) < samples or not math.isfinite(other[-1]):
        return False
    decreasing = all(later < earlier for earlier, later in pairwise(other[-samples:]))
    return decreasing and other[-1] < current
