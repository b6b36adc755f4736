"""Kernel: how long ways over the hubs of labels are, while an index is built.

Labels lie in one *pool* of (hub, length, edge towards it) each, that of a node from ``begins`` to ``ends``, hubs in the
order of importance. One of two labels is laid out first: ``reach`` tells how far each of its hubs is.
"""

import numpy as np

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import FAR
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.jit_decorators import bare, joined
from ppaas.planners.kernels.prefetch import LINE, fetch

AT_A_TIME = LINE
"""Entries after which it is asked whether they tell a way that is short enough: the most important hubs mostly do."""


@joined
def lay_out(reach: Integers, hubs: Integers, lengths: Integers, begin: int, end: int) -> None:
    """Tell how far the hubs of a label are."""
    for i in range(begin, end):
        reach[hubs[i]] = lengths[i]


@joined
def take_back(reach: Integers, hubs: Integers, begin: int, end: int) -> None:
    """Forget how far the hubs of a label are."""
    for i in range(begin, end):
        reach[hubs[i]] = FAR


@joined
def least(reach: Integers, hubs: Integers, lengths: Integers, begin: int, end: int) -> int:
    """Return the least of reach[hub] + length over a stretch of labels; `FAR` or more if no hub is reached."""
    best = np.int32(0x7FFFFFFF)
    for i in range(begin, end):
        best = min(best, np.int32(reach[np.uint64(hubs[i])] + lengths[i]))
    return int(best)


@joined
def told(reach: Integers, hubs: Integers, lengths: Integers, begin: int, end: int, most: int) -> int:
    """Return how long a way over some hub is if one is ``most`` long or less, not always the best; else more."""
    for first in range(begin, end, AT_A_TIME):
        best = least(reach, hubs, lengths, first, min(first + AT_A_TIME, end))
        if best <= most:
            return int(best)
    return most + 1


@joined
def announce(hubs: Integers, lengths: Integers, begin: int) -> None:
    """Begin to bring the entries of a label at which `told` looks first."""
    for place in (begin, begin + LINE):
        fetch(hubs, place)
        fetch(lengths, place)


@bare
def tell_lengths(
    root: int, labelled: int, hubs: Integers, lengths: Integers, begins: Words, ends: Words,
    of_root: Integers, far: Integers,
) -> None:  # fmt: skip
    """Tell how far nodes are from one, by their labels.

    Parameters
    ----------
    root, labelled : int
        The node, and how many nodes have labels; they are the first.
    hubs, lengths, begins, ends
        The labels.
    of_root : (``labelled``,) int32 array
        `FAR` everywhere, before and after.
    far : (``labelled``,) int32 array
        Out; `FAR` or more where there is no way.
    """
    lay_out(of_root, hubs, lengths, begins[root], ends[root])
    for node in range(labelled):
        far[node] = least(of_root, hubs, lengths, begins[node], ends[node])
    take_back(of_root, hubs, begins[root], ends[root])


def warm() -> None:
    """Compile and call each kernel once."""
    nothing, far = np.empty(0, np.int32), np.zeros(1, np.int64)
    tell_lengths(0, 0, nothing, nothing, far, far, nothing, nothing)
