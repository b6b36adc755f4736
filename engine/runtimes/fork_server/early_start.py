"""What a fork server loads, and its early start: it takes as long as all that its agent loads for itself.

Nothing of the kind is imported here.
"""

import multiprocessing
from multiprocessing import forkserver

RUNTIME = "process"
"""Name of the runtime that forks containers."""

CONTAINER = "engine.container.entry:main"
REHEARSED = "engine.container.warm_up.run"

PRELOAD, FROZEN = "engine.container.warm_up.preload", "engine.container.warm_up.freeze"

_context = multiprocessing.get_context("forkserver")


def choose(entry: str, rehearsed: str | None = None) -> None:
    """Have the fork server of this process, when it is started, load what containers use.

    Parameters
    ----------
    entry : str
        ``"module:function"`` that containers run.
    rehearsed : str, optional
        Module that is loaded after that of ``entry``.
    """
    entered = entry.partition(":")[0]
    _context.set_forkserver_preload([PRELOAD, entered, *([rehearsed] if rehearsed else []), FROZEN])


def begin() -> None:
    """Start the fork server of containers, and wait for nothing: whoever forks the first one does that."""
    choose(CONTAINER, REHEARSED)
    forkserver.ensure_running()
