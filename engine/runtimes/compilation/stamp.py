"""Notes on the compiled kernels of a cache: a stamp file if all are compiled, and notes on single modules.

numba has no query for its cache: the only check is to load each kernel, which takes seconds for all of them. So the
process that compiled them notes their sources and their files in the cache.

All compilers of a cache share notes on its single modules, also in other clouds on this computer. So one that was
killed is continued, one that waits for another knows how far that is, and the one that compiles begins with what is
waited for.
"""

import contextlib
import fcntl
import logging
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import IO

import msgspec

from engine.processes.disk_notes import note_file, write_note
from ppaas.decoding import from_json
from ppaas.kernel_cache.sources import stamp_of

logger = logging.getLogger(__name__)

SERIAL = "serial"
"""Threading layer without threads."""

QUIET = "ignore:resource_tracker:UserWarning"
"""Option ``-W`` of compilers, so that the resource tracker of one that is killed warns of nothing."""


def stamp_file(root: Path, layer: str) -> Path:
    """Return the path of the note for the current sources of the kernels below a folder.

    The name depends on these sources, on the versions of Python, numba and llvmlite, and on the processor for which
    they are compiled.

    Parameters
    ----------
    root : Path
        Folder of the package.
    layer : str
        Threading layer that the kernels are compiled for.
    """
    from ppaas.kernel_cache.target import compile_target  # noqa: PLC0415  # imports LLVM, which the agent does not need

    versions = (sys.version, version("numba"), version("llvmlite"))
    return note_file("compiled", (*versions, layer, str(root), *compile_target(), stamp_of(root)))


def is_compiled(root: Path, layer: str) -> bool:
    """Return whether all kernels below a folder are compiled for a threading layer: here, or where they came from."""
    from ppaas.kernel_cache.shipped import shipped_folder  # noqa: PLC0415  # imports LLVM, as above

    return (SERIAL not in layer and shipped_folder() is not None) or all_compiled(stamp_file(root, layer))


def all_compiled(stamp: Path) -> bool:
    """Return whether the note exists, and all files that it names."""
    return noted_files(stamp) is not None


def noted_files(note: Path) -> list[str] | None:
    """Return the files that a note names; None if there is no such note, or one of the files is missing."""
    try:
        files = from_json(note.read_bytes(), list[str])
    except (OSError, msgspec.DecodeError):
        return None
    return files if all(map(os.path.exists, files)) else None


def write_files(note: Path, files: Iterable[str]) -> None:
    """Write a note on files, unless one of them does not exist; raises ``OSError`` if it cannot be written."""
    files = sorted(set(files))
    if all(map(os.path.exists, files)):
        write_note(note, files)


def note(stamp: Path, files: Iterable[str]) -> None:
    """Note that all kernels are compiled into these files. Does nothing if one of the files does not exist."""
    try:
        write_files(stamp, files)
    except OSError as error:
        logger.warning("cannot note that all kernels are compiled, so the next start loads them all again: %s", error)


def cache_files(module: ModuleType) -> Sequence[str]:
    """Return the index files in the cache of those kernels of a module that were called."""
    from numba.core.dispatcher import Dispatcher  # noqa: PLC0415  # after its threading layer is chosen

    called = [found for found in vars(module).values() if isinstance(found, Dispatcher) and found.signatures]
    return [str(vars(kernel)["_cache"]._cache_file._index_path) for kernel in called if kernel.stats.cache_path]


_WANTED = ".wanted"


class ModuleNotes:
    """Notes in a folder beside a stamp file. Where it cannot be written, this process alone knows them.

    Parameters
    ----------
    stamp_file : Path
        Stamp file of all kernels of the cache (``stamp_file``).
    """

    def __init__(self, stamp_file: Path) -> None:
        self._folder = stamp_file.with_suffix("")
        self._lock_file = stamp_file.with_suffix(".lock")
        self._files: dict[str, list[str]] = {}
        self._wanted: set[str] = set()

    def compiled(self) -> dict[str, list[str]]:
        """Return the index files in the cache of each compiled module, by its name."""
        for note in self._folder.glob("*.json"):
            name = note.name.removesuffix(".json")
            if name not in self._files and (files := noted_files(note)) is not None:
                self._files[name] = files
        return self._files

    def note(self, module: str, files: Iterable[str]) -> None:
        """Note that a module is compiled into these files."""
        self._files[module] = sorted(files)
        self._wanted.discard(module)
        with contextlib.suppress(OSError):  # then this process alone knows it, and the next one loads the kernels again
            write_files(self._folder / f"{module}.json", self._files[module])
            (self._folder / f"{module}{_WANTED}").unlink(missing_ok=True)

    def want(self, modules: Iterable[str]) -> None:
        """Note that somebody waits for modules."""
        for module in set(modules) - self.compiled().keys():
            self._wanted.add(module)
            with contextlib.suppress(OSError):  # then the compiler of this process alone knows it
                self._folder.mkdir(parents=True, exist_ok=True)
                (self._folder / f"{module}{_WANTED}").touch()

    def wanted(self) -> set[str]:
        """Return the modules that somebody waits for."""
        marked = {mark.name.removesuffix(_WANTED) for mark in self._folder.glob(f"*{_WANTED}")}
        return (marked | self._wanted) - self.compiled().keys()

    @contextlib.contextmanager
    def turn(self) -> Iterator[bool]:
        """Enter with true if no other process compiles into this cache until the context ends, else with false.

        Where the file of the lock cannot be created, nothing is locked.
        """
        try:
            self._lock_file.parent.mkdir(parents=True, exist_ok=True)
            lock = self._lock_file.open("w")
        except OSError:
            yield True
            return
        with lock:
            yield _locked(lock)


def _locked(lock: IO[str]) -> bool:
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
