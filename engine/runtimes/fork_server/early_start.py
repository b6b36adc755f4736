"""Modules of the fork server, its early start, in which its imports run in parallel to the agent's, and its end.

This module must not import any of them.
"""

import multiprocessing
import os
import signal
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing import forkserver

RUNTIME = "process"
"""Name of the runtime that forks containers."""

_context = multiprocessing.get_context("forkserver")


def choose(modules: Sequence[str]) -> None:
    """Set the modules that the fork server of this process imports when it starts, in this order."""
    _context.set_forkserver_preload(list(modules))


def begin(modules: Sequence[str]) -> None:
    """Start the fork server of containers without waiting; the first fork waits for it."""
    choose(modules)
    forkserver.ensure_running()


def end() -> None:
    """Kill the fork server of this process, if it runs, and wait until it has exited; another can be started then.

    By itself it exits after this process, at the earliest once its imports have ended: it takes seconds to free its
    memory on a busy machine. No process that it forked may be needed any longer.
    """
    for pid in server():
        with suppress(ChildProcessError):  # it was started by the parent of this process, or has been waited for
            if os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT | os.WNOHANG) is None:
                os.kill(pid, signal.SIGKILL)
                os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)  # the library still has to wait for it


def server() -> tuple[int, ...]:
    """Return the process id of the fork server, running or dead, for which the library waits at the next start."""
    pid: int | None = forkserver._forkserver._forkserver_pid  # type: ignore[attr-defined]
    return () if pid is None else (pid,)
