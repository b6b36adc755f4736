"""Compiles the kernels that not every container uses, beside a machine that runs already.

A cloud has many planners, and most robots one. To compile the kernels of all before the first container takes minutes
on a new computer, and to load them all takes seconds of every start and memory of every container. So the fork server
loads what every container uses, and this, in a process of low priority, compiles the others into the cache. A kernel
that is called later is loaded from there, in milliseconds; one called earlier is compiled where it is called.
"""

import asyncio
import contextlib
import logging
import os
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import ppaas
from engine.processes.background import Background
from engine.processes.disk_notes import alone
from engine.processes.parent_watch import end_with
from engine.runtimes.compilation import compile_pool, stamp, threading_layer

logger = logging.getLogger(__name__)

COMMAND = (sys.executable, "-m", __spec__.name)
LOWEST_PRIORITY = 19


@contextlib.asynccontextmanager
async def compiling_the_rest() -> AsyncIterator[None]:
    """Have the rest compiled as long as this lasts; what is not finished then, the next start goes on with."""
    background = Background()
    background.run(_compile_beside())
    try:
        yield
    finally:
        await background.cancel()


async def _compile_beside() -> None:
    process = await asyncio.create_subprocess_exec(*COMMAND, str(os.getpid()), stdin=asyncio.subprocess.DEVNULL)
    try:
        status = await process.wait()
        if status:
            logger.warning("the compiler of kernels ended with status %d: planners may be slow when first used", status)
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


def main() -> None:
    """Compile all kernels on all processors, unless it is known that they are; for a parent, as long as that lives."""
    for parent in sys.argv[1:2]:
        end_with(int(parent))
    os.nice(LOWEST_PRIORITY)
    noted = stamp.stamp_file(Path(ppaas.__path__[0]), threading_layer.choose())
    if stamp.all_compiled(noted):
        return
    with alone(noted.with_suffix(".lock")):
        if not stamp.all_compiled(noted):  # another may just have done it
            stamp.note(noted, compile_pool.compile_all(_names))


def _names() -> list[str]:
    from engine.runtimes.compilation import kernel_modules  # noqa: PLC0415  # numba, after the choice of its layer

    return [module.__name__ for module in kernel_modules.modules()]


if __name__ == "__main__":
    main()
