"""Kernels that were compiled on another computer: the package ``ppaas_kernels``, where it is installed.

``ppaas warm --wheel`` makes it. It is used if it was compiled from the same sources, by the same versions, for the same
processor; otherwise it is ignored, and kernels are compiled as usual.
"""

import functools
import importlib.util
import sys
from importlib.metadata import version
from pathlib import Path

import msgspec

import ppaas
from ppaas.decoding import from_json
from ppaas.kernel_cache.sources import stamp_of
from ppaas.kernel_cache.target import compile_target

PACKAGE = "ppaas_kernels"
MANIFEST = "manifest.json"


class Manifest(msgspec.Struct, frozen=True):
    """What kernels were compiled from, by and for.

    Parameters
    ----------
    sources : str
        Hash of all kernel files (`stamp_of`).
    python, numba, llvmlite : str
        Versions; that of Python without its third number.
    cpu_name, cpu_features : str
        Processor.
    """

    sources: str
    python: str
    numba: str
    llvmlite: str
    cpu_name: str
    cpu_features: str

    @classmethod
    def of_this_process(cls) -> "Manifest":
        """Return the manifest of kernels that this process would compile."""
        python = f"{sys.version_info.major}.{sys.version_info.minor}"
        sources = stamp_of(Path(ppaas.__path__[0]))
        return cls(sources, python, version("numba"), version("llvmlite"), *compile_target())


_ignored: list[str] = []


def ignore_shipped() -> None:
    """Ignore the package in this process and its forks, which compile kernels otherwise.

    Call it before any kernel is imported.
    """
    _ignored.append(PACKAGE)


@functools.cache
def shipped_folder() -> Path | None:
    """Return the folder of the package if its kernels are those that this process would compile, else None."""
    found = None if _ignored else importlib.util.find_spec(PACKAGE)
    for place in map(Path, (found and found.submodule_search_locations) or ()):
        try:
            manifest = from_json((place / MANIFEST).read_bytes(), Manifest)
        except (OSError, msgspec.DecodeError):
            continue
        if manifest == Manifest.of_this_process():
            return place
    return None
