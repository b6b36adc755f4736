"""Spare processes: started before they are needed, they import their modules, and then wait for their settings."""

import asyncio
import logging
import os
from asyncio.subprocess import PIPE, Process
from collections.abc import Mapping, Sequence

from engine.processes.child_process import end

logger = logging.getLogger(__name__)

STOP_GRACE = 5.0
"""Time for a process to exit by itself once its standard input is closed [s]."""


async def start_process(command: Sequence[str], environment: Mapping[str, str] = os.environ) -> Process:
    """Start a process that takes its settings from standard input.

    It has its own session, so that a signal from the terminal does not end it before the processes that need it.

    Raises
    ------
    OSError
        The process cannot be started.
    """
    return await asyncio.create_subprocess_exec(*command, stdin=PIPE, start_new_session=True, env=dict(environment))


class SpareProcesses:
    """Processes of one command that have no settings yet. They exit when their standard input is closed.

    Parameters
    ----------
    command : sequence of str
        Command that runs each of them.
    """

    def __init__(self, command: Sequence[str]) -> None:
        self._command = command
        self._waiting: list[Process] = []

    async def start(self, number: int) -> None:
        """Start a number of processes; if one cannot be started, there are fewer."""
        try:
            for _ in range(number):
                self._waiting.append(await start_process(self._command))
        except OSError as error:
            logger.warning("a process cannot be started ahead, and will be when it is needed: %s", error)

    def take(self) -> Process | None:
        """Return a process that waits for its settings, which now belongs to the caller; None if none is left."""
        while self._waiting:
            process = self._waiting.pop()
            if process.returncode is None:
                return process
        return None

    async def close(self) -> None:
        """End the processes that were not taken."""
        waiting, self._waiting = self._waiting, []
        await asyncio.gather(*(end(process, STOP_GRACE) for process in waiting))
