"""What a fork server loads, and its early start: it takes as long as all that its agent loads for itself.

Nothing of the kind is imported here.
"""

import multiprocessing
from collections.abc import Sequence
from multiprocessing import forkserver

RUNTIME = "process"
"""Name of the runtime that forks containers."""

_context = multiprocessing.get_context("forkserver")


def choose(modules: Sequence[str]) -> None:
    """Have the fork server of this process, when it is started, load modules in this order."""
    _context.set_forkserver_preload(list(modules))


def begin(modules: Sequence[str]) -> None:
    """Start the fork server of containers, and wait for nothing: whoever forks the first one does that."""
    choose(modules)
    forkserver.ensure_running()
