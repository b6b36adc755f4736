"""Memory of a process that others are forked from: gaps are filled, free memory is returned, and code is compacted.

The interpreter writes into code objects as it runs them: call counters and inline caches. Code objects are in memory
in the order in which modules were imported, so those that a container runs are scattered among those that it never
runs, and each function that it calls costs it a private copy of a page or two. Code objects that are copied one after
the other take a fifth of these pages.
"""

import ctypes
import gc
import sys
import threading
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from types import CodeType, FrameType, FunctionType

from engine.runtimes.memory_tuning.switch import LEAN

# -- gaps between objects ----------------------------------------------------------------------------------------------

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


# -- free memory -------------------------------------------------------------------------------------------------------

_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD, _M_ARENA_MAX = -1, -3, -8

_LARGE, _MUCH = 256 * 1024, 512 * 1024
"""Bytes from which a block is mapped by itself, and free bytes at the end of the heap above which it shrinks."""


def trim_early() -> None:
    """Make the C library return large blocks as soon as they are free: a plan takes some megabytes once a second.

    Blocks up to 256 kB, such as the text of a path, are kept: returning them would cost page faults of some
    microseconds each. By default the C library raises its threshold after the first large array, keeps the memory of
    such arrays, and does so for each thread.

    The settings apply to this process and its forks. Does nothing if the C library has no ``mallopt``.
    """
    if not LEAN:
        return
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        for parameter, value in ((_M_MMAP_THRESHOLD, _LARGE), (_M_TRIM_THRESHOLD, _MUCH), (_M_ARENA_MAX, 1)):
            mallopt(parameter, value)


def trim() -> None:
    """Return the free pages of the C library's heap to the system. Does nothing if it has no ``malloc_trim``."""
    if not LEAN:
        return
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


# -- code --------------------------------------------------------------------------------------------------------------


def compact(run: Callable[[], object]) -> int:
    """Run a function, replace all code that it ran by copies in all functions, and return the number of copies.

    The inline caches of the interpreter are not copied. Each container fills them again, on pages that it would write
    to anyway. Running everything again here would save 0.1 MB and take longer than all other steps.
    """
    if not LEAN:
        run()
        return 0
    with _recorded() as ran:
        run()
    functions = [each for each in gc.get_objects() if type(each) is FunctionType]  # a proxy would pass isinstance()
    copies: dict[int, CodeType] = {}
    for function in functions:
        code = _copied(function.__code__, ran, copies)
        if code is not function.__code__:
            function.__code__ = code
    return len(copies)


@contextmanager
def _recorded() -> Iterator[Collection[int]]:
    """Record the ids of the code objects that run, in this thread and in threads that are started meanwhile."""
    ran: dict[int, CodeType] = {}  # keeps the code alive, so that its id is not reused

    def note(frame: FrameType, _event: str, _argument: object) -> None:
        ran[id(frame.f_code)] = frame.f_code

    threading.setprofile(note)
    sys.setprofile(note)
    try:
        yield ran
    finally:
        sys.setprofile(None)
        threading.setprofile(None)


def _copied(code: CodeType, ran: Collection[int], copies: dict[int, CodeType]) -> CodeType:
    """Return the copy of a code object, or itself if neither it nor code defined in it ran."""
    if id(code) not in copies:
        constants = tuple(_copied(c, ran, copies) if isinstance(c, CodeType) else c for c in code.co_consts)
        if id(code) not in ran and all(a is b for a, b in zip(constants, code.co_consts, strict=True)):
            return code
        copies[id(code)] = code.replace(co_consts=constants)
    return copies[id(code)]
