"""Restarts the fork server once if it had to compile, to free the memory that the compiler used."""

import os
import sys
from collections.abc import Mapping

_RESTARTED = "PPAAS_BEGUN_ANEW"


def restart_once(environment: Mapping[str, str]) -> None:
    """Restart this program, once, as every container would inherit the memory that the compiler used.

    The second run loads the kernels from the cache. If kernels cannot be cached, there is no further restart.

    Parameters
    ----------
    environment : mapping
        Environment with which this program was started.
    """
    if _RESTARTED not in environment:
        os.execve(sys.executable, sys.orig_argv, {**environment, _RESTARTED: "1"})
