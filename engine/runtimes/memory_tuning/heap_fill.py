"""Heap fill: fills the gaps between the objects of a process, before others are forked from it.

A child allocates new objects in free gaps, first between the objects that it shares with its parent. Each of them costs
it a private copy of that page. Once the gaps are filled, new objects are adjacent, on new pages. The blocks that are
allocated here are never freed; they are on pages that are shared anyway.
"""

import ctypes
import sys
from collections.abc import Callable

from engine.runtimes.memory_tuning.switch import LEAN

POOL = 1 << 14
"""Size of a pool of the interpreter, from which it allocates blocks of one size [bytes]."""

POOL_HEADER = 48
"""Size of a pool's header [bytes]."""
SMALL = range(16, 513, 16)
"""Sizes of the blocks of pools [bytes]."""

LARGE = (1 << 17, 1 << 16, 1 << 15, 1 << 14, 1 << 13, 1 << 12, 2_048, 1_024, 512, 256, 128, 64, 24)
"""Sizes of blocks to allocate from the C library [bytes]; smaller ones fill the rest of a gap.

Whole free pages take no memory, not even when they are allocated here. But large arrays of a child would be placed
there, and the heap can return memory to the system only from its end.
"""

MOST = 1 << 21
"""Upper limit of the bytes allocated in one size, in case the layout of the heap is not the expected one."""

Allocate = Callable[[int], int]
Free = Callable[[int], None]


def fill() -> int:
    """Fill all gaps between objects, and between blocks of the C library; return the number of bytes.

    The heap of the C library is only filled if the library has ``sbrk``.
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
    sys._clear_type_cache()  # otherwise a child frees cached names one by one, each on another page
    return taken


def _fill_pools(allocate: Allocate, size: int) -> int:
    """Allocate blocks of one size until they have filled a whole new pool."""
    taken, pool, of_this_pool = 0, -1, 0
    while of_this_pool < (POOL - POOL_HEADER) // size and taken < MOST:
        here = allocate(size) // POOL
        of_this_pool = of_this_pool + 1 if here == pool else 1
        pool, taken = here, taken + size
    return taken


def _fill_heap(allocate: Allocate, free: Free, end: int) -> int:
    """Allocate blocks of each size while they are placed below the former end of the heap."""
    taken, behind = 0, []
    for size in LARGE:
        most = taken + MOST * (size >> 10 or 1)
        while (address := allocate(size)) + size < end and taken < most:
            taken += size
        behind.append(address)
    for address in behind:
        free(address)
    return taken
