"""Kernel: bucket queue of (length, node) for graphs without edges shorter than the width of a bucket.

No node in a bucket can shorten the path to another one in it, so the order inside a bucket does not matter, and no
sorting as in a heap is needed (Dial, "Algorithm 360: Shortest-Path Forest with Topological Ordering", 1969; Denardo and
Fox, "Shortest-Route Methods: 1", 1979).

``buckets`` holds the newest entry of each bucket, or −1. It is circular and must cover more than the longest edge.
``entries`` holds for each entry its key, as in `heap`, and the previous entry of its bucket. Entries are not reused
until the queue is empty.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import joined
from ppaas.planners.hub_labels.kernels.scan import STRAIGHT, Integers

Entries = NDArray[np.int64]

WIDTH = STRAIGHT.bit_length() - 1
"""Width of a bucket as a shift [bits]; at most the length of a straight move."""

KEY, BEFORE, ENTRY = range(3)
"""Columns of an entry."""


def buckets_for(longest: int) -> int:
    """Return the number of buckets for edges up to this length."""
    return 1 << ((longest >> WIDTH) + 1).bit_length()


@joined
def put(buckets: Integers, entries: Entries, count: int, length: int, node: int) -> int:
    """Insert a node into a queue that received ``count`` entries before; return the new count."""
    bucket = (length >> WIDTH) & (len(buckets) - 1)
    entries[count, KEY] = (length << 32) | node
    entries[count, BEFORE] = buckets[bucket]
    buckets[bucket] = count
    return count + 1


@joined
def next_bucket(buckets: Integers, bucket: int) -> int:
    """Return the next bucket that is not empty, from ``bucket`` on; there must be one."""
    while buckets[bucket & (len(buckets) - 1)] < 0:
        bucket += 1
    return bucket


@joined
def take(buckets: Integers, entries: Entries, bucket: int) -> int:
    """Remove and return the newest key of a bucket that is not empty."""
    place = bucket & (len(buckets) - 1)
    entry = buckets[place]
    buckets[place] = entries[entry, BEFORE]
    return int(entries[entry, KEY])
