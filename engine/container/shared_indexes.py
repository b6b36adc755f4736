"""Shared indexes: planners' indexes of a map, made by the machine and mapped by its containers."""

import asyncio
import logging
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path

from engine.container.machine_client import MachineClient
from engine.specs.layer_files import open_index
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

SLICE = 0.005
"""Time between two checks whether the index is still needed [s]."""


class SharedIndexes:
    """Opens the indexes in a folder of layers, and makes the machine prepare missing ones.

    Planning threads call it, and block until the index is there; the event loop does not block.

    Parameters
    ----------
    folder : Path
        Folder with the layers.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._machine: tuple[MachineClient, asyncio.AbstractEventLoop] | None = None

    def ask(self, machine: MachineClient, loop: asyncio.AbstractEventLoop) -> None:
        """Request missing indexes from a machine, on its event loop, from now on."""
        self._machine = machine, loop

    def of(self, folder: Path) -> "SharedIndexes":
        """Return the indexes in another folder of layers, from the same machine."""
        other = SharedIndexes(folder)
        other._machine = self._machine
        return other

    def __call__(self, planner: str, check: Callable[[], None]) -> memoryview | None:
        """Return a planner's index of the map; None if the machine cannot make it now.

        Parameters
        ----------
        planner : str
            Name of the planner.
        check : callable
            Called while waiting; raises if the index is no longer needed.

        Raises
        ------
        InvalidPlanner
            The planner cannot prepare this map.
        """
        try:
            content = open_index(self._folder, planner)
            if content is None and self._machine is not None:
                machine, loop = self._machine
                _await(asyncio.run_coroutine_threadsafe(machine.prepare_index(planner), loop), check)
                content = open_index(self._folder, planner)
        except Unavailable as error:
            logger.warning("planner %s runs without a shared index: %s", planner, error)
            return None
        return content


def _await(asked: Future[None], check: Callable[[], None]) -> None:
    try:
        while True:
            check()
            try:
                return asked.result(SLICE)
            except TimeoutError:
                continue
    finally:
        asked.cancel()
