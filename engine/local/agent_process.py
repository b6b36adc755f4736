"""The agent of this very machine, as a process that is started again whenever it dies."""

import asyncio
import contextlib
import logging
import os
import signal
from asyncio.subprocess import PIPE, Process
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

import msgspec

from engine.agent import main as agent_main
from engine.local.adopted_process import AdoptedProcess
from engine.runtimes.memory_tuning import lean_python

logger = logging.getLogger(__name__)

RESTART_DELAYS = (0.0, 0.5, 2.0, 5.0)
"""Seconds before the first, second … start after a death; a minute of life begins the row anew."""

STEADY = 60.0
STOP_GRACE = 5.0

COMMAND = (*lean_python.PYTHON, "-m", agent_main.__name__)


class AgentSettings(Protocol):
    """What an agent is told at its start: a ``msgspec.Struct``."""

    @property
    def machine(self) -> str:
        """Name of its machine."""
        ...


class AgentProcess:
    """Keeps an agent running.

    Parameters
    ----------
    config : AgentSettings
        Handed over on its standard input, so that no secret shows among the processes.
    command : sequence of str
        That runs it.
    done : int, optional
        Status by which an agent says that it is not to be started again.
    environment : mapping of str to str
        That it and its containers get of this process's.
    started : callable
        Told the process id of each agent that is started.
    """

    def __init__(
        self,
        config: AgentSettings,
        command: Sequence[str] = COMMAND,
        done: int | None = None,
        environment: Mapping[str, str] = os.environ,
        started: Callable[[int], None] = lambda _: None,
    ) -> None:
        self._config = config
        self._command = command
        self._done = done
        self._environment = environment
        self._started = started
        self._found: AdoptedProcess | None = None
        self._process: Process | AdoptedProcess | None = None
        self._keeper: asyncio.Task[None] | None = None
        self._deaths = 0

    @property
    def deaths(self) -> int:
        """How often it died or could not be started, one time soon after the other."""
        return self._deaths

    @property
    def pid(self) -> int | None:
        """Of the agent that runs now."""
        return self._process.pid if self._process is not None else None

    def adopt(self, pid: int) -> None:
        """Keep an agent that runs already, instead of a first one; nothing happens where it has ended."""
        with contextlib.suppress(ProcessLookupError):
            self._process = self._found = AdoptedProcess(pid)

    async def start(self) -> None:
        """Start the agent, and go on starting it."""
        self._keeper = asyncio.create_task(self._keep())

    async def ended(self) -> None:
        """Wait until it is started no more."""
        if self._keeper is not None:
            await asyncio.wait([self._keeper])

    async def _keep(self) -> None:
        loop = asyncio.get_running_loop()
        while True:
            began = loop.time()
            status = await self._live()
            if status is not None and status == self._done:
                return
            self._deaths = 0 if loop.time() - began > STEADY else self._deaths + 1
            delay = RESTART_DELAYS[min(self._deaths, len(RESTART_DELAYS)) - 1] if self._deaths else 0.0
            await asyncio.sleep(delay)

    async def _live(self) -> int | None:
        """Run the agent once; return its status, or None if it could not be started."""
        machine = self._config.machine
        try:
            process, self._found = self._found or await self._spawn(), None
        except OSError as error:
            logger.warning("the agent of machine %r could not be started: %s", machine, error)
            return None
        self._process = process
        status = await process.wait()
        logger.warning("the agent of machine %r ended: status %s", machine, status)
        return status

    async def _spawn(self) -> Process:
        # In a session of its own, a signal to the terminal's processes does not end it before those who need it.
        process = await asyncio.create_subprocess_exec(
            *self._command, stdin=PIPE, start_new_session=True, env=lean_python.environment(self._environment)
        )
        if process.stdin is None:
            raise RuntimeError("the agent has no standard input")
        process.stdin.write(msgspec.json.encode(self._config))
        process.stdin.close()
        self._started(process.pid)
        return process

    def kill(self) -> None:
        """End the agent by force, with what it started: it is frozen, and is started again."""
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)

    async def stop(self) -> None:
        """End the agent, by force with what it started if it does not go by itself."""
        if self._keeper is not None:
            self._keeper.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._keeper
        process = self._process
        if process is None or process.returncode is not None:
            return
        process.terminate()  # it may not have dialled yet, and then no link that hangs up tells it
        try:
            async with asyncio.timeout(STOP_GRACE):
                await process.wait()
        except TimeoutError:
            logger.warning("the agent of machine %r did not end by itself and is killed", self._config.machine)
            self.kill()
            await process.wait()
