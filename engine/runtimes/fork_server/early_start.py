"""Modules of the fork server, and its early start: its imports run in parallel to those of the agent.

This module must not import any of them.
"""

import multiprocessing
from collections.abc import Sequence
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
