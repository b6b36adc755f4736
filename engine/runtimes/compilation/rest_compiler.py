"""Compiles the kernels that not every container uses, in the background of a running machine.

A cloud has many planners, and most robots use one. Compiling the kernels of all planners before the first container
takes minutes on a new computer; loading them all takes seconds at every start and memory in every container. So the
fork server loads the kernels that every container uses, and a process of low priority compiles the others into the
cache. A kernel that is called later is loaded from there within milliseconds; one that is called earlier is compiled
by its caller.
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
from engine.processes.disk_notes import exclusive
from engine.processes.parent_watch import end_with
from engine.runtimes.compilation import compile_pool, stamp, threading_layer

logger = logging.getLogger(__name__)

COMMAND = (sys.executable, "-m", __spec__.name)
LOWEST_PRIORITY = 19


@contextlib.asynccontextmanager
async def compiling_the_rest() -> AsyncIterator[None]:
    """Compile the remaining kernels while this context is open; the next start continues with unfinished ones."""
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
            logger.warning("the kernel compiler exited with status %d: planners may be slow at their first use", status)
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


def main() -> None:
    """Compile all kernels on all processors, unless a note says that they are compiled.

    The first command-line argument, if any, is the id of the parent process, with which this process exits.
    """
    for parent in sys.argv[1:2]:
        end_with(int(parent))
    os.nice(LOWEST_PRIORITY)
    noted = stamp.stamp_file(Path(ppaas.__path__[0]), threading_layer.choose())
    if stamp.all_compiled(noted):
        return
    with exclusive(noted.with_suffix(".lock")):
        if not stamp.all_compiled(noted):  # another process may just have done it
            stamp.note(noted, compile_pool.compile_all(_names))


def _names() -> list[str]:
    from engine.runtimes.compilation import kernel_modules  # noqa: PLC0415  # imports numba, after its layer is chosen

    return [module.__name__ for module in kernel_modules.modules()]


if __name__ == "__main__":
    main()
