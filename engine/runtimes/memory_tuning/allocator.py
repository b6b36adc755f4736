"""Makes the C library return free memory to the system, in a fork server and the processes forked from it."""

import ctypes

from engine.runtimes.memory_tuning.switch import LEAN

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
