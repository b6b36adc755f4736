"""Invalidation of numba's cache: a change of any kernel file makes all kernels compile anew.

A kernel is compiled together with the kernels it calls and with their constants, but numba only checks whether the
kernel's own file has changed. After an update, a cached kernel would still contain the old code of the kernels it
calls. So every package of kernels calls `watch_all_kernels` before it imports a module with kernels.
"""

import functools
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

from numba.core import caching

import ppaas

KERNELS = "kernels"
"""Name of the packages that contain kernels."""


class _File(caching._SourceFileBackedLocatorMixin):
    """Locator that gives numba's stamp (time of modification and size) of one file."""

    def __init__(self, file: Path) -> None:
        self._py_file = str(file)


@functools.cache
def _stamp_of_all_kernels() -> str:
    """Return a hash of the stamps of all kernel files, which are read once per process."""
    root = _root()
    files = sorted(root.rglob(f"{KERNELS}/*.py"))
    stamps = [(str(file.relative_to(root)), _File(file).get_source_stamp()) for file in files]  # type: ignore[no-untyped-call]
    return hashlib.sha256(repr(stamps).encode()).hexdigest()


@functools.cache
def _root() -> Path:
    return Path(ppaas.__path__[0])


class _OfAllKernels(caching._SourceFileBackedLocatorMixin):
    """Locator of this project's kernels: numba's folder, but a stamp that depends on all kernel files."""

    def get_source_stamp(self) -> str:
        return _stamp_of_all_kernels()

    @classmethod
    def from_function(cls, function: Callable[..., Any], file: str) -> Self | None:
        if not Path(file).is_relative_to(_root()):
            return None
        found: Self | None = super().from_function(function, file)  # type: ignore[no-untyped-call]
        return found


class _InGivenFolder(_OfAllKernels, caching.UserProvidedCacheLocator):
    """Cache in the folder given by ``NUMBA_CACHE_DIR``."""


class _BesideSource(_OfAllKernels, caching.InTreeCacheLocator):
    """Cache beside the source, where that folder is writable."""


class _InHome(_OfAllKernels, caching.UserWideCacheLocator):
    """Cache in the user's cache folder."""


class _Index(caching.IndexDataCacheFile):
    """Index of a kernel's compiled signatures, which is unpickled only if no kernel has changed.

    The index contains argument types, and one of an earlier version may refer to a type that no longer exists. numba
    compares the version, unpickles, and then compares the stamp. So the stamp is made part of the version.
    """

    def __init__(self, cache_path: str, filename_base: str, source_stamp: Any) -> None:
        super().__init__(cache_path, filename_base, source_stamp)  # type: ignore[no-untyped-call]
        if isinstance(source_stamp, str):  # numba's own are tuples
            self._version = f"{self._version} {source_stamp}"


def watch_all_kernels() -> None:
    """Make the kernels imported from now on compile again after any kernel of this project has changed."""
    locators: list[Any] = caching.CacheImpl._locator_classes
    locators[:0] = [own for own in (_InGivenFolder, _BesideSource, _InHome) if own not in locators]
    caching.IndexDataCacheFile = _Index  # type: ignore[misc]
