"""Ends a process when its parent exits."""

import ctypes
import os
import signal
import sys

_PR_SET_PDEATHSIG = 1


def end_with(parent: int) -> None:
    """Make the kernel send SIGTERM to this process when its parent exits; exit at once if it has exited already.

    Parameters
    ----------
    parent : int
        Process id of the parent, which the parent has passed to this process.
    """
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)
    if os.getppid() != parent:
        sys.exit(f"the parent process {parent} has exited already")
