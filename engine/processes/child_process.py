"""End of child processes and of other processes of this machine, and adoption of orphans."""

import asyncio
import contextlib
import ctypes
import os
import signal
from asyncio.subprocess import Process
from collections.abc import Callable, Collection, Iterator
from pathlib import Path

from engine.processes.background import repeat
from engine.processes.instances import is_dead, name_of, pid_of

# -- children ----------------------------------------------------------------------------------------------------------


async def end(process: Process, grace: float) -> None:
    """Close the standard input of a process, and wait for its exit; kill it after a time [s]."""
    if process.stdin is not None:
        process.stdin.close()
    try:
        async with asyncio.timeout(grace):
            await process.wait()
    except TimeoutError:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()


# -- other processes of this machine -----------------------------------------------------------------------------------

END_GRACE = 5.0
"""Time for a process to exit by itself after SIGTERM [s]."""

BLINK = 0.02
"""Time between two checks whether it has exited [s]."""


async def end_process(instance: str) -> None:
    """Stop a process, which leads a process group; kill the group if the process does not exit by itself.

    Parameters
    ----------
    instance : str
        Instance name of the process.
    """
    os.kill(pid_of(instance), signal.SIGTERM)
    try:
        async with asyncio.timeout(END_GRACE):
            while not is_dead(instance):  # noqa: ASYNC110 - it is not our child
                await asyncio.sleep(BLINK)
    except TimeoutError:
        os.killpg(pid_of(instance), signal.SIGKILL)


# -- orphans -----------------------------------------------------------------------------------------------------------

ORPHAN_PERIOD = 2.0
"""Time between two looks for orphans that have exited [s]."""

_PR_SET_CHILD_SUBREAPER = 36


def adopt_orphans(adopt: bool) -> None:
    """Make this process the subreaper of its descendants, or not (``PR_SET_CHILD_SUBREAPER`` in prctl(2))."""
    ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, int(adopt), 0, 0, 0)


class OrphanReaper:
    """Reaps adopted processes of which nobody else in this process knows.

    Linux does not say which children are adopted. So a child is reaped that has been a zombie for two looks in a row:
    code here that had started it would have reaped it by then, except those in ``known``.

    Parameters
    ----------
    known : callable
        Returns the ids of children that others reap, however late.
    """

    def __init__(self, known: Callable[[], Collection[int]]) -> None:
        self._known = known
        self._before: set[int] = set()

    async def run(self) -> None:
        """Look for zombies until cancelled."""
        await repeat(self._check, ORPHAN_PERIOD)

    async def _check(self) -> None:
        self.look()

    def look(self) -> None:
        """Reap the zombies that the look before has found, too."""
        zombies = {child for child in _children() if name_of(child) is None}.difference(self._known())
        for child in zombies & self._before:
            with contextlib.suppress(ChildProcessError):  # reaped by its parent after all
                os.waitpid(child, os.WNOHANG)
        self._before = zombies - self._before


def _children() -> Iterator[int]:
    for file in Path("/proc/self/task").glob("*/children"):
        with contextlib.suppress(OSError):  # this thread has just ended
            yield from map(int, file.read_text().split())
