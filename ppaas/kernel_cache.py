"""Has numba's cache take a compiled kernel only as long as no kernel at all has changed.

A kernel is compiled together with those that it calls, and with their constants, but numba asks only whether its own
file is the same. So after an update a kernel would go on with what it calls as that was before: at best it is wrong.
Packages of kernels call `watch_all_kernels` before any of their modules is imported.
"""

import functools
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

from numba.core import caching

import ppaas

KERNELS = "kernels"
"""Name of the packages in which kernels lie."""


class _File(caching._SourceFileBackedLocatorMixin):
    """Has numba tell whether one file is the same."""

    def __init__(self, file: Path) -> None:
        self._py_file = str(file)


@functools.cache
def _made_from() -> str:
    """Return what tells whether all kernels are the same as before; they are looked at once in a process."""
    root = _root()
    files = sorted(root.rglob(f"{KERNELS}/*.py"))
    stamps = [(str(file.relative_to(root)), _File(file).get_source_stamp()) for file in files]  # type: ignore[no-untyped-call]
    return hashlib.sha256(repr(stamps).encode()).hexdigest()


@functools.cache
def _root() -> Path:
    return Path(ppaas.__path__[0])


class _OfAllKernels(caching._SourceFileBackedLocatorMixin):
    """Says where a kernel of this project is kept, as numba does, and that it is made from all of them."""

    def get_source_stamp(self) -> str:
        return _made_from()

    @classmethod
    def from_function(cls, function: Callable[..., Any], file: str) -> Self | None:
        if not Path(file).is_relative_to(_root()):
            return None
        found: Self | None = super().from_function(function, file)  # type: ignore[no-untyped-call]
        return found


class _InGivenFolder(_OfAllKernels, caching.UserProvidedCacheLocator):
    """In the folder that ``NUMBA_CACHE_DIR`` tells."""


class _BesideSource(_OfAllKernels, caching.InTreeCacheLocator):
    """Beside the source, where that can be written to."""


class _InHome(_OfAllKernels, caching.UserWideCacheLocator):
    """In the folder that the user has for what is cached."""


class _Index(caching.IndexDataCacheFile):
    """Index of what is compiled of one kernel, unpickled only if no kernel has changed.

    It names the types of arguments, so that of a kernel before a change may name a type that is no more. numba looks at
    the version first, then unpickles, and looks at the stamp last.
    """

    def __init__(self, cache_path: str, filename_base: str, source_stamp: Any) -> None:
        super().__init__(cache_path, filename_base, source_stamp)  # type: ignore[no-untyped-call]
        if isinstance(source_stamp, str):  # numba's own are tuples
            self._version = f"{self._version} {source_stamp}"


def watch_all_kernels() -> None:
    """Have kernels of this project that are imported from now on compiled again after any of them has changed."""
    locators: list[Any] = caching.CacheImpl._locator_classes
    locators[:0] = [own for own in (_InGivenFolder, _BesideSource, _InHome) if own not in locators]
    caching.IndexDataCacheFile = _Index  # type: ignore[misc]
