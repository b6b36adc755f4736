"""Moves a process that runs to other CPUs."""

import os
from contextlib import suppress
from pathlib import Path


def move_threads(pid: int, cpus: tuple[int, ...]) -> None:
    """Let every thread of a process run on these CPUs, and no other; nothing happens where it is gone.

    A thread takes the CPUs over from the one that starts it, so this goes on until it finds none that is new.
    """
    moved: set[int] = set()
    with suppress(ProcessLookupError, FileNotFoundError):
        while new := _threads(pid) - moved:
            for thread in new:
                with suppress(ProcessLookupError):  # it ended just now
                    os.sched_setaffinity(thread, cpus)
            moved |= new


def _threads(pid: int) -> set[int]:
    return {int(task.name) for task in Path(f"/proc/{pid}/task").iterdir()}
