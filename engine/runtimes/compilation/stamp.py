"""Stamp file: a note on disk that all kernels are compiled in the cache.

numba has no query for its cache: the only check is to load each kernel, which takes seconds for all of them. So the
process that compiled them notes their sources and their files in the cache.
"""

import logging
import os
import sys
from collections.abc import Iterable, Sequence
from importlib.metadata import version
from pathlib import Path
from types import ModuleType

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
