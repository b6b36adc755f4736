"""Restarts the fork server once if it had to compile: what a compiler leaves behind would be in every container."""

import os
import sys
from collections.abc import Mapping

_RESTARTED = "PPAAS_BEGUN_ANEW"


def restart_once(environment: Mapping[str, str]) -> None:
    """Run this program again from its start, once: what the compiler leaves behind would be in every container.

    The second time all that was compiled comes from the cache. Where nothing can be cached, it stays at one time.

    Parameters
    ----------
    environment : mapping
        That this program was started with.
    """
    if _RESTARTED not in environment:
        os.execve(sys.executable, sys.orig_argv, {**environment, _RESTARTED: "1"})
