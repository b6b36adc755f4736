"""Kernel: a queue of (length, node) in buckets by length, for graphs of which no edge is shorter than a bucket is wide.

What is in one bucket makes nothing else in it shorter, so it does not matter what is taken first, and nothing has to be
kept in order as in a heap (Dial, "Algorithm 360: Shortest-Path Forest with Topological Ordering", 1969; Denardo and
Fox, "Shortest-Route Methods: 1", 1979).

``buckets`` tells the newest entry of each, or −1; they go round, so they must be more than the longest edge is long.
``entries`` tells the key of each, as in `heap`, and the entry of its bucket before it. Entries are not used again until
the queue is empty.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.hub_labels.kernels.scan import STRAIGHT, Integers
from ppaas.planners.kernels.jit_decorators import joined

Entries = NDArray[np.int64]

WIDTH = STRAIGHT.bit_length() - 1
"""A bucket is so many bits wide, which is no more than one move."""

KEY, BEFORE, ENTRY = range(3)


def buckets_for(longest: int) -> int:
    """Return how many buckets there must be for edges up to so long."""
    return 1 << ((longest >> WIDTH) + 1).bit_length()


@joined
def put(buckets: Integers, entries: Entries, puts: int, length: int, node: int) -> int:
    """Put a node into a queue to which so many were put before, and return how many they are then."""
    bucket = (length >> WIDTH) & (len(buckets) - 1)
    entries[puts, KEY] = (length << 32) | node
    entries[puts, BEFORE] = buckets[bucket]
    buckets[bucket] = puts
    return puts + 1


@joined
def next_bucket(buckets: Integers, bucket: int) -> int:
    """Return the next bucket with anything in it, from one on; there must be one."""
    while buckets[bucket & (len(buckets) - 1)] < 0:
        bucket += 1
    return bucket


@joined
def take(buckets: Integers, entries: Entries, bucket: int) -> int:
    """Take the newest key out of a bucket that is not empty."""
    place = bucket & (len(buckets) - 1)
    entry = buckets[place]
    buckets[place] = entries[entry, BEFORE]
    return int(entries[entry, KEY])
