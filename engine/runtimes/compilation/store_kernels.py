"""Prepares the kernels that stores use to write and read plans."""

import sys
from pathlib import Path

from engine.processes.disk_notes import exclusive
from ppaas.plans import encoding


def prepare() -> None:
    """Load the kernels from the cache, or compile them: at the first plan this would block all robots.

    Call it once, in a thread, before any kernel is called. If several processes do so on a new computer, one compiles
    and the others wait for it. Once the stamp file exists no process waits: another one that compiles for a different
    cloud, or is stopped, must not block this one.
    """
    # Imported here because numba takes a third of a second.
    from engine.runtimes.compilation import kernel_modules, stamp  # noqa: PLC0415
    from engine.runtimes.memory_tuning import cached_kernels  # noqa: PLC0415

    cached_kernels.load_without_compiler()
    from ppaas.plans.encoding import kernels  # noqa: PLC0415

    if stamp.is_compiled(*_of_stores()):
        kernel_modules.warm_package(kernels)
        return
    noted = stamp_of_stores()
    with exclusive(noted.with_suffix(".lock")):
        modules = kernel_modules.warm_package(kernels)
    stamp.note(noted, [file for module in modules for file in stamp.cache_files(module)])


def stamp_of_stores() -> Path:
    """Return the stamp file of these kernels for this process."""
    from engine.runtimes.compilation import stamp  # noqa: PLC0415  # as above

    return stamp.stamp_file(*_of_stores())


def _of_stores() -> tuple[Path, str]:
    return Path(encoding.__path__[0]), f"stores, -O{sys.flags.optimize}"  # -O changes the bytecode
