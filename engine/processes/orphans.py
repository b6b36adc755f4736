"""Adoption of orphans: descendants whose parent was killed become children of this process, and leave no zombies."""

import contextlib
import ctypes
import os
from collections.abc import Callable, Collection, Iterator
from pathlib import Path

from engine.processes.background import repeat
from engine.processes.instances import name_of

PERIOD = 2.0
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
        await repeat(self._check, PERIOD)

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
