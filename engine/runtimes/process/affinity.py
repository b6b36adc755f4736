"""CPU affinity of a running process, with all its threads."""

import os
from contextlib import suppress
from pathlib import Path


def move_threads(pid: int, cpus: tuple[int, ...]) -> None:
    """Restrict all threads of a process to these CPUs. Does nothing if the process has exited.

    A new thread inherits the CPUs of the thread that starts it, so this repeats until it finds no new thread.
    """
    moved: set[int] = set()
    with suppress(ProcessLookupError, FileNotFoundError):
        while new := _threads(pid) - moved:
            for thread in new:
                with suppress(ProcessLookupError):  # the thread has just ended
                    os.sched_setaffinity(thread, cpus)
            moved |= new


def _threads(pid: int) -> set[int]:
    return {int(task.name) for task in Path(f"/proc/{pid}/task").iterdir()}
