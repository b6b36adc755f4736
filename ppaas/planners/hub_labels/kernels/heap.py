"""Kernel: a binary heap of (length, node) in an array of int64, length in the upper half and node in the lower."""

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.kernels.jit_decorators import joined

NODE = 0xFFFFFFFF
"""The lower half of a key."""


@joined
def push(heap: Words, size: int, length: int, node: int) -> int:
    """Put a key into a heap of that size, which has room for it, and return the size then."""
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
    """Take the least key, ``heap[0]``, out of a heap of that size and return the size then."""
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
