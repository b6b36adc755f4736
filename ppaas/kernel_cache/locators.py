"""Invalidation of numba's cache: a change of any kernel file makes all kernels compile anew.

A kernel is compiled together with the kernels it calls and with their constants, but numba only checks whether the
kernel's own file has changed. After an update, a cached kernel would still contain the old code of the kernels it
calls. So every package of kernels calls `watch_all_kernels` before it imports a module with kernels.

Kernels that no cache on this computer has may be shipped: see `shipped`.
"""

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

from numba.core import caching

import ppaas
from ppaas.kernel_cache.shipped import shipped_folder
from ppaas.kernel_cache.sources import stamp_of
from ppaas.kernel_cache.target import use_target


@functools.cache
def _stamp_of_all_kernels() -> str:
    """Return a hash of all kernel files, which are read once per process."""
    return stamp_of(_root())


@functools.cache
def _root() -> Path:
    return Path(ppaas.__path__[0])


class _OfAllKernels(caching._SourceFileBackedLocatorMixin):
    """Locator of this project's kernels: numba's folder, but a stamp that depends on all kernel files."""

    _py_file: str

    def get_source_stamp(self) -> str:
        package = ".".join(Path(self._py_file).relative_to(_root()).parent.parts)
        return f"{_stamp_of_all_kernels()} {package}"

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


class KernelIndex(caching.IndexDataCacheFile):
    """Index of a kernel's compiled signatures, which is unpickled only if no kernel has changed.

    The index contains argument types, and one of an earlier version may refer to a type that no longer exists. numba
    compares the version, unpickles, and then compares the stamp. So the stamp is made part of the version.

    Signatures that this index lacks are looked up in the index of the shipped kernels.
    """

    def __init__(self, cache_path: str, filename_base: str, source_stamp: Any, *, alone: bool = False) -> None:
        super().__init__(cache_path, filename_base, source_stamp)  # type: ignore[no-untyped-call]
        self._shipped: KernelIndex | None = None
        if not isinstance(source_stamp, str):
            return  # numba's own are bytes or tuples: a kernel of somebody else
        self._version = f"{self._version} {source_stamp}"
        folder = None if alone else shipped_folder()
        if folder is not None:
            place = str(folder / source_stamp.split()[1])
            self._shipped = KernelIndex(place, filename_base, source_stamp, alone=True)

    def _load_index(self) -> dict[Any, str]:
        try:
            here: dict[Any, str] = super()._load_index()  # type: ignore[no-untyped-call]
        except Exception:  # noqa: BLE001  # a damaged pickle raises anything; what it named is compiled again
            here = {}
        return self._shipped_files() | here

    def entries(self) -> dict[Any, str]:
        """Return the names of the files of all compiled signatures."""
        return self._load_index()

    def write_entries(self, entries: dict[Any, str]) -> None:
        """Replace the index by the names of these files."""
        self._save_index(entries)  # type: ignore[no-untyped-call]

    def _shipped_files(self) -> dict[Any, str]:
        """Return the absolute paths of shipped files by their signatures: numba joins them to the path of its cache."""
        shipped = self._shipped
        return {} if shipped is None else {key: shipped._data_path(name) for key, name in shipped._load_index().items()}  # type: ignore[no-untyped-call]

    def _load_data(self, name: str) -> Any:
        try:
            return super()._load_data(name)  # type: ignore[no-untyped-call]
        except Exception as error:  # a damaged pickle raises anything
            raise OSError(f"{name} is no compiled kernel") from error  # numba compiles it, as if the file were missing

    def save(self, key: Any, data: Any) -> None:
        """Save a compiled signature in this index; it is preferred to what is shipped from now on."""
        self._shipped = None
        super().save(key, data)  # type: ignore[no-untyped-call]


def watch_all_kernels() -> None:
    """Make the kernels imported from now on compile again after any kernel of this project has changed."""
    use_target()
    locators: list[Any] = caching.CacheImpl._locator_classes
    locators[:0] = [own for own in (_InGivenFolder, _BesideSource, _InHome) if own not in locators]
    caching.IndexDataCacheFile = KernelIndex  # type: ignore[misc]
