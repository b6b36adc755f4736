"""The kernels by which stores write and read plans, for processes that keep plans while they serve others."""

import sys
from pathlib import Path

from engine.processes.disk_notes import alone
from ppaas.plans import encoding


def prepare() -> None:
    """Load them, from the cache where they are compiled: done with the first plan, it would hold up all robots.

    Call it in a thread, once, before anything else calls a kernel. Of several processes that do so on a new computer
    one compiles, and the others wait for it. Once it is noted that they are compiled, nobody waits for anybody: who
    compiles for another cloud, or stands still meanwhile, must not keep this one from serving its robots.
    """
    # So here: with numba, which takes a third of a second.
    from engine.runtimes.compilation import kernel_modules, stamp  # noqa: PLC0415
    from engine.runtimes.memory_tuning import cached_kernels  # noqa: PLC0415

    cached_kernels.load_without_compiler()
    from ppaas.plans.encoding import kernels  # noqa: PLC0415

    noted = stamp_of_stores()
    if stamp.all_compiled(noted):
        kernel_modules.warm_package(kernels)
        return
    with alone(noted.with_suffix(".lock")):
        modules = kernel_modules.warm_package(kernels)
    stamp.note(noted, [file for module in modules for file in stamp.cache_files(module)])


def stamp_of_stores() -> Path:
    """Return where it is noted that they are compiled as this process needs them: without texts, code is another."""
    from engine.runtimes.compilation import stamp  # noqa: PLC0415  # as above

    return stamp.stamp_file(Path(encoding.__path__[0]), f"stores, -O{sys.flags.optimize}")
