"""A program that another process starts and reads: it ends with that process, and prints its answers alone."""

import ctypes
import os
import signal
import sys
from typing import BinaryIO

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


def take_standard_output() -> BinaryIO:
    """Return standard output; what the process and its children print from now on goes to standard error.

    Children do not inherit it, so its reader does not wait for their end.
    """
    own = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    return own
