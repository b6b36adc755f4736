"""Kernel: lengths of paths over the hubs of labels, while an index is built.

Labels are ranges of one *pool* of entries (hub, distance, edge towards the hub), sorted by importance of the hubs. The
label of a node is at ``begins[node]:ends[node]``. To compare two labels, the first is scattered: ``reach`` holds the
distance of each of its hubs.
"""

import numpy as np

from ppaas.kernel_cache.decorators import bare, joined
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import FAR
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.prefetch import LINE, fetch

BLOCK = LINE
"""Entries compared before each test whether the path is short enough: the most important hubs usually decide."""


@joined
def scatter(reach: Integers, hubs: Integers, lengths: Integers, begin: int, end: int) -> None:
    """Write the distances of a label into an array indexed by hub."""
    for i in range(begin, end):
        reach[hubs[i]] = lengths[i]


@joined
def clear(reach: Integers, hubs: Integers, begin: int, end: int) -> None:
    """Reset the distances of a scattered label."""
    for i in range(begin, end):
        reach[hubs[i]] = FAR


@joined
def minimum(reach: Integers, hubs: Integers, lengths: Integers, begin: int, end: int) -> int:
    """Return the minimum of reach[hub] + length over a range of entries; `FAR` or more if no hub is reached."""
    best = np.int32(0x7FFFFFFF)
    for i in range(begin, end):
        best = min(best, np.int32(reach[np.uint64(hubs[i])] + lengths[i]))
    return int(best)


@joined
def length_up_to(reach: Integers, hubs: Integers, lengths: Integers, begin: int, end: int, most: int) -> int:
    """Return the length of a path over some hub if one is at most ``most``, not always the shortest; else more."""
    for first in range(begin, end, BLOCK):
        best = minimum(reach, hubs, lengths, first, min(first + BLOCK, end))
        if best <= most:
            return int(best)
    return most + 1


@joined
def prefetch(hubs: Integers, lengths: Integers, begin: int) -> None:
    """Prefetch the entries of a label that `length_up_to` reads first."""
    for place in (begin, begin + LINE):
        fetch(hubs, place)
        fetch(lengths, place)


@bare
def lengths_from(
    root: int, labelled: int, hubs: Integers, lengths: Integers, begins: Words, ends: Words,
    from_root: Integers, far: Integers,
) -> None:  # fmt: skip
    """Compute the distances of nodes from a root, from their labels.

    Parameters
    ----------
    root, labelled : int
        The root, and the number of labelled nodes; they are the first.
    hubs, lengths, begins, ends
        Pool of labels, as in `core_labels.add_entries`.
    from_root : (``labelled``,) int32 array
        Scratch: `FAR` before and after.
    far : (``labelled``,) int32 array
        Out: distances; `FAR` or more without a path.
    """
    scatter(from_root, hubs, lengths, begins[root], ends[root])
    for node in range(labelled):
        far[node] = minimum(from_root, hubs, lengths, begins[node], ends[node])
    clear(from_root, hubs, begins[root], ends[root])


def warm() -> None:
    """Compile and call each kernel once."""
    nothing, far = np.empty(0, np.int32), np.zeros(1, np.int64)
    lengths_from(0, 0, nothing, nothing, far, far, nothing, nothing)
