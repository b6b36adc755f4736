"""Kernel: binary heap of keys (length, node) in an int64 array: length in the upper 32 bits, node in the lower."""

from ppaas.kernel_cache.decorators import joined
from ppaas.planners.hub_labels.kernels.bits import Words

NODE = 0xFFFFFFFF
"""Mask of the node in a key."""


@joined
def push(heap: Words, size: int, length: int, node: int) -> int:
    """Insert a key into a heap with ``size`` keys and free capacity; return the new size."""
    key = (length << 32) | node
    at = size
    while at > 0:
        parent = (at - 1) >> 1
        if heap[parent] <= key:
            break
        heap[at] = heap[parent]
        at = parent
    heap[at] = key
    return size + 1


@joined
def pop(heap: Words, size: int) -> int:
    """Remove the smallest key, ``heap[0]``; return the new size."""
    size -= 1
    key = heap[size]
    at = 0
    child = 1
    while child < size:
        if child + 1 < size and heap[child + 1] < heap[child]:
            child += 1
        if heap[child] >= key:
            break
        heap[at] = heap[child]
        at = child
        child = 2 * at + 1
    heap[at] = key
    return size
