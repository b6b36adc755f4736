"""A note that all kernels lie compiled in the cache.

numba looks into its cache kernel by kernel, and can be asked only by loading what it finds, which takes seconds for all
of them. So whoever has compiled them all notes what they were made from and where they lie.
"""

import logging
import os
import sys
from collections.abc import Iterable, Sequence
from importlib.metadata import version
from pathlib import Path
from types import ModuleType

import msgspec

from engine.processes.disk_notes import note_file, source_of, write_note

logger = logging.getLogger(__name__)

KERNELS = "kernels"
"""Name of the packages in which kernels lie."""


def stamp_file(root: Path, layer: str) -> Path:
    """Return where the note lies for what the kernels below a folder are made from now.

    Parameters
    ----------
    root : Path
        Folder of the domain's package.
    layer : str
        Threading layer that they are compiled for.
    """
    from llvmlite import binding  # noqa: PLC0415  # with LLVM, which the agent needs not

    sources = sorted(file for file in root.rglob("*.py") if KERNELS in file.relative_to(root).parts)
    made_from = [
        sys.version, version("numba"), version("llvmlite"), layer, str(root),
        os.environ.get("NUMBA_CPU_NAME") or binding.get_host_cpu_name(),
        os.environ.get("NUMBA_CPU_FEATURES") or binding.get_host_cpu_features().flatten(),
        *map(source_of, sources),
    ]  # fmt: skip
    return note_file("compiled", made_from)


def all_compiled(stamp: Path) -> bool:
    """Tell whether the note is there, and all that it names."""
    try:
        return all(map(os.path.exists, msgspec.json.decode(stamp.read_bytes(), type=list[str])))
    except (OSError, msgspec.DecodeError):
        return False


def note(stamp: Path, files: Iterable[str]) -> None:
    """Note that all kernels are compiled, into these files; nothing is noted where they were not kept."""
    files = sorted(set(files))
    if not all(map(os.path.exists, files)):
        return
    try:
        write_note(stamp, files)
    except OSError as error:
        logger.warning("not noted that all kernels are compiled, so they are loaded to see it: %s", error)


def cache_files(module: ModuleType) -> Sequence[str]:
    """Return the index files of the cache for the kernels of a module that were called."""
    from numba.core.dispatcher import Dispatcher  # noqa: PLC0415  # after the choice of its threading layer

    called = [found for found in vars(module).values() if isinstance(found, Dispatcher) and found.signatures]
    return [str(vars(kernel)["_cache"]._cache_file._index_path) for kernel in called if kernel.stats.cache_path]
