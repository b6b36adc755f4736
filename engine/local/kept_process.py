"""The agent of the local machine, as a process that is restarted whenever it exits."""

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
"""Delays before the first, second … restart in a row [s]; an uptime of ``STEADY`` resets the row."""

STEADY = 60.0
STOP_GRACE = 5.0
"""Time for the agent to exit by itself after SIGTERM [s]."""

COMMAND = (*lean_python.PYTHON, "-m", agent_main.__name__)


class AgentSettings(Protocol):
    """Settings of an agent at its start: a ``msgspec.Struct``."""

    @property
    def machine(self) -> str:
        """Name of the agent's machine."""
        ...


class AgentProcess:
    """Keeps an agent running.

    Parameters
    ----------
    config : AgentSettings
        Settings, passed on standard input so that no secret shows in the process list.
    command : sequence of str
        Command that runs the agent.
    done : int, optional
        Exit status of an agent that must not be restarted.
    environment : mapping of str to str
        Environment of the agent and its containers.
    started : callable
        Called with the process id of each agent that is started.
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
        self._adopted: AdoptedProcess | None = None
        self._process: Process | AdoptedProcess | None = None
        self._keeper: asyncio.Task[None] | None = None
        self._deaths = 0

    @property
    def deaths(self) -> int:
        """Number of times in a row that it exited early or could not be started."""
        return self._deaths

    @property
    def pid(self) -> int | None:
        """Process id of the running agent."""
        return self._process.pid if self._process is not None else None

    def adopt(self, pid: int) -> None:
        """Use an agent that runs already as the first one. Does nothing if it has exited."""
        with contextlib.suppress(ProcessLookupError):
            self._process = self._adopted = AdoptedProcess(pid)

    async def start(self) -> None:
        """Start the agent, and restart it whenever it exits."""
        self._keeper = asyncio.create_task(self._keep())

    async def ended(self) -> None:
        """Wait until it is not restarted any more."""
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
            process, self._adopted = self._adopted or await self._spawn(), None
        except OSError as error:
            logger.warning("the agent of machine %r could not be started: %s", machine, error)
            return None
        self._process = process
        status = await process.wait()
        logger.warning("the agent of machine %r exited with status %s", machine, status)
        return status

    async def _spawn(self) -> Process:
        # In its own session, so that a signal from the terminal does not end it before the processes that need it.
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
        """Kill the frozen agent with all its child processes; it is restarted."""
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)

    async def stop(self) -> None:
        """Stop the agent; kill it with all its child processes if it does not exit by itself."""
        if self._keeper is not None:
            self._keeper.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._keeper
        process = self._process
        if process is None or process.returncode is not None:
            return
        process.terminate()  # it may not have a control link yet whose end would stop it
        try:
            async with asyncio.timeout(STOP_GRACE):
                await process.wait()
        except TimeoutError:
            logger.warning(
                "the agent of machine %r did not exit within its time limit and is killed", self._config.machine
            )
            self.kill()
            await process.wait()
