"""What a fork server does so that the processes it forks take little memory of their own."""

import ctypes
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD, _M_ARENA_MAX = -1, -3, -8
_LARGE, _MUCH = 256 * 1024, 512 * 1024
_BEGUN_ANEW = "PPAAS_BEGUN_ANEW"

UNUSED_EXTRAS = ("_hashlib", "cffi", "scipy", "ssl", "typing_extensions", "yaml")
"""What numba, msgspec and Python's own library load where it is installed. Nothing of ours needs them for it, and they
take 14 MB. Without OpenSSL Python makes sums by itself, and asyncio has no TLS: a container speaks to its machine only.
"""


def give_back_early() -> None:
    """Let the C library give memory back as soon as it is free: a plan takes some megabytes once a second.

    What the text of a path takes stays: each of its pages is a fault of some microseconds if it has to come anew.

    Left alone it takes the first large array for a hint, keeps what such arrays leave, and does so for each thread.
    It holds for this process and for all that are forked from it. Nothing happens where the C library has no such
    settings.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        for parameter, value in ((_M_MMAP_THRESHOLD, _LARGE), (_M_TRIM_THRESHOLD, _MUCH), (_M_ARENA_MAX, 1)):
            mallopt(parameter, value)


def give_back() -> None:
    """Give back the pages of the C library's heap that are free; nothing happens where it cannot."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


@contextmanager
def without_extras() -> Iterator[None]:
    """Let nothing load the unused extras; afterwards everything may, such as a plug-in that needs them itself."""
    hidden = [name for name in UNUSED_EXTRAS if name not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]  # None: the import system finds no such module
    try:
        yield
    finally:
        for name in hidden:
            if sys.modules.get(name, name) is None:
                del sys.modules[name]


def begin_anew(environment: Mapping[str, str]) -> None:
    """Run this program again from its start, once: what the compiler leaves behind would be in every container.

    The second time all that was compiled comes from the cache. Where nothing can be cached, it stays at one time.

    Parameters
    ----------
    environment : mapping
        That this program was started with.
    """
    if _BEGUN_ANEW not in environment:
        os.execve(sys.executable, sys.orig_argv, {**environment, _BEGUN_ANEW: "1"})
