"""Fills the gaps between the objects of a process, before others are forked from it.

A child puts its new objects where it finds room, first between those that it shares with its parent; each of them costs
it a copy of the page around. Once the gaps are filled, new objects come to lie side by side on pages of their own. What
is taken here is never given back; it lies on pages that all share anyway.
"""

import ctypes
import sys
from collections.abc import Callable

from engine.runtimes.memory_tuning.switch import LEAN

POOL = 1 << 14
"""Bytes from which the interpreter hands out blocks of one size."""

POOL_HEADER = 48
SMALL = range(16, 513, 16)
"""Sizes of such blocks."""

LARGE = (1 << 17, 1 << 16, 1 << 15, 1 << 14, 1 << 13, 1 << 12, 2_048, 1_024, 512, 256, 128, 64, 24)
"""Sizes of blocks that the C library is asked for: what of a gap is left goes to the next smaller ones.

What is free over whole pages takes no memory before it is used, nor when it is taken. But a child's large arrays would
come to lie there, and memory that they leave is given back from behind all others only.
"""

MOST = 1 << 21
"""Bytes that are taken of one size at most, if memory is laid out otherwise than is thought here."""

Allocate = Callable[[int], int]
Free = Callable[[int], None]


def fill() -> int:
    """Take all room between objects, and between blocks of the C library; return how many bytes that was.

    Nothing is done about the latter where the C library has no heap that grows.
    """
    if not LEAN:
        return 0
    interpreter, library = ctypes.pythonapi, ctypes.CDLL(None)
    small, large = interpreter.PyObject_Malloc, library.malloc
    for allocate in (small, large):
        allocate.restype, allocate.argtypes = ctypes.c_void_p, [ctypes.c_size_t]
    library.free.restype, library.free.argtypes = None, [ctypes.c_void_p]
    taken = sum(_fill_pools(small, size) for size in SMALL)
    if hasattr(library, "sbrk"):
        library.sbrk.restype = ctypes.c_void_p
        taken += _fill_heap(large, library.free, library.sbrk(0))
    sys._clear_type_cache()  # else a child lets go of cached names one by one, each on a page of its own
    return taken


def _fill_pools(allocate: Allocate, size: int) -> int:
    """Take blocks of one size until a whole pool of them had been free."""
    taken, pool, of_this_pool = 0, -1, 0
    while of_this_pool < (POOL - POOL_HEADER) // size and taken < MOST:
        here = allocate(size) // POOL
        of_this_pool = of_this_pool + 1 if here == pool else 1
        pool, taken = here, taken + size
    return taken


def _fill_heap(allocate: Allocate, free: Free, end: int) -> int:
    """Take blocks of each size as long as they come from before the end that the heap had."""
    taken, behind = 0, []
    for size in LARGE:
        most = taken + MOST * (size >> 10 or 1)
        while (address := allocate(size)) + size < end and taken < most:
            taken += size
        behind.append(address)
    for address in behind:
        free(address)
    return taken
