"""The kernels by which stores write and read plans, for processes that keep plans while they serve others."""

import sys
from importlib.util import find_spec
from pathlib import Path

from engine.processes.disk_notes import alone

PACKAGE = "ppaas.plans.kernels"


def prepare() -> None:
    """Load them, from the cache where they are compiled: done with the first plan, it would hold up all robots.

    Call it in a thread, once, before anything else calls a kernel. Of several processes that do so on a new computer
    one compiles, and the others wait for it. Once it is noted that they are compiled, nobody waits for anybody: who
    compiles for another cloud, or stands still meanwhile, must not keep this one from serving its robots.
    """
    from engine.runtimes.compilation import kernel_modules
    from engine.runtimes.compilation import stamp as kernel_stamp  # noqa: PLC0415  # with numba: a third of a second
    from engine.runtimes.memory_tuning import cached_kernels

    cached_kernels.load_without_compiler()
    noted = stamp()
    if kernel_stamp.all_compiled(noted):
        kernel_modules.warm_package(PACKAGE)
        return
    with alone(noted.with_suffix(".lock")):
        modules = kernel_modules.warm_package(PACKAGE)
    kernel_stamp.note(noted, [file for module in modules for file in kernel_stamp.cache_files(module)])


def stamp() -> Path:
    """Return where it is noted that they are compiled as this process needs them: without texts, code is another."""
    from engine.runtimes.compilation import stamp as kernel_stamp  # noqa: PLC0415  # as above

    spec = find_spec(PACKAGE)
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError(PACKAGE)
    return kernel_stamp.stamp_file(Path(spec.origin).parents[1], f"stores, -O{sys.flags.optimize}")
