"""Has the C library give free memory back to the system: a fork server does, and so do the processes it forks."""

import ctypes

from engine.runtimes.memory_tuning.switch import LEAN

_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD, _M_ARENA_MAX = -1, -3, -8
_LARGE, _MUCH = 256 * 1024, 512 * 1024


def trim_early() -> None:
    """Let the C library give memory back as soon as it is free: a plan takes some megabytes once a second.

    What the text of a path takes stays: each of its pages is a fault of some microseconds if it has to come anew.

    Left alone it takes the first large array for a hint, keeps what such arrays leave, and does so for each thread.
    It holds for this process and for all that are forked from it. Nothing happens where the C library has no such
    settings.
    """
    if not LEAN:
        return
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        for parameter, value in ((_M_MMAP_THRESHOLD, _LARGE), (_M_TRIM_THRESHOLD, _MUCH), (_M_ARENA_MAX, 1)):
            mallopt(parameter, value)


def trim() -> None:
    """Give back the pages of the C library's heap that are free; nothing happens where it cannot."""
    if not LEAN:
        return
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
