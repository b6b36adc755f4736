"""What a machine has prepared of a map for planners, as the container that stands in it asks for it."""

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
"""Seconds between two looks at whether it is still wanted."""


class SharedIndexes:
    """Opens indexes that lie beside the layers of a map, and has the machine make those that do not.

    It is called by the threads that plan; they wait for it, the loop does not.

    Parameters
    ----------
    folder : Path
        Of the layers.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._machine: tuple[MachineClient, asyncio.AbstractEventLoop] | None = None

    def ask(self, machine: MachineClient, loop: asyncio.AbstractEventLoop) -> None:
        """Ask this machine, on that loop, from now on."""
        self._machine = machine, loop

    def __call__(self, planner: str, check: Callable[[], None]) -> memoryview | None:
        """Return what a planner has prepared of the map; None if nobody can.

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
            logger.warning("no index of %s is shared: %s", planner, error)
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
