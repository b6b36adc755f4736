"""Process of a cloud that is restarted whenever it exits: the agent of the local machine, or an endpoint.

Spares are started before they are needed: they import their modules, and then wait for their settings.
"""

import asyncio
import contextlib
import logging
import os
import signal
from asyncio.subprocess import PIPE, Process
from collections.abc import Callable, Mapping, Sequence

import msgspec

from engine.agent import main as agent_main
from engine.processes.child_process import end
from engine.runtimes.memory_tuning import lean_python

logger = logging.getLogger(__name__)

STOP_GRACE = 5.0
"""Time for a process to exit by itself once its standard input is closed [s]."""


# -- spares ------------------------------------------------------------------------------------------------------------


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


# -- kept processes ----------------------------------------------------------------------------------------------------

RESTART_DELAYS = (0.0, 0.5, 2.0, 5.0)
"""Delays before the first, second … restart in a row [s]; an uptime of ``STEADY`` resets the row."""

STEADY = 60.0

AGENT = (*lean_python.PYTHON, "-m", agent_main.__name__)
"""Command that runs an agent."""

UNKNOWN = 255
"""Exit status of a process that is not our child: it cannot be read."""


class AdoptedProcess:
    """Process that was not started by this one, as an ``asyncio.subprocess.Process``; created within an event loop.

    Parameters
    ----------
    pid : int
        Process id.

    Raises
    ------
    ProcessLookupError
        The process has exited.
    """

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self.returncode: int | None = None
        self._pidfd = os.pidfd_open(pid)
        self._ended = asyncio.Event()
        asyncio.get_running_loop().add_reader(self._pidfd, self._on_end)

    def _on_end(self) -> None:
        asyncio.get_running_loop().remove_reader(self._pidfd)
        os.close(self._pidfd)
        self.returncode = UNKNOWN
        self._ended.set()

    async def wait(self) -> int:
        """Wait until the process exits; return ``UNKNOWN``."""
        await self._ended.wait()
        return UNKNOWN

    def terminate(self) -> None:
        """Send SIGTERM."""
        if self.returncode is None:
            signal.pidfd_send_signal(self._pidfd, signal.SIGTERM)


class KeptProcess:
    """Keeps a process running.

    Parameters
    ----------
    title : str
        Description of the process for the log.
    config : Struct or Raw
        Settings, passed as JSON on standard input so that no secret shows in the process list.
    command : sequence of str
        Command that runs the process.
    done : int, optional
        Exit status of a process that must not be restarted.
    environment : mapping of str to str
        Environment of the process and its children.
    started : callable
        Called with the id of each process that is started.
    spares : SpareProcesses, optional
        Processes of ``command`` that were started earlier; used before another one is started.
    """

    def __init__(
        self,
        title: str,
        config: msgspec.Struct | msgspec.Raw,
        command: Sequence[str] = AGENT,
        *,
        done: int | None = None,
        environment: Mapping[str, str] = os.environ,
        started: Callable[[int], None] = lambda _: None,
        spares: SpareProcesses | None = None,
    ) -> None:
        self._title = title
        self._config = config
        self._command = command
        self._done = done
        self._environment = environment
        self._started = started
        self._spares = spares
        self._adopted: AdoptedProcess | None = None
        self._process: Process | AdoptedProcess | None = None
        self._keeper: asyncio.Task[None] | None = None
        self._deaths = 0

    def change(self, config: msgspec.Struct | msgspec.Raw) -> None:
        """Start the next process with other settings."""
        self._config = config

    @property
    def deaths(self) -> int:
        """Number of times in a row that it exited early or could not be started."""
        return self._deaths

    @property
    def pid(self) -> int | None:
        """Id of the running process."""
        return self._process.pid if self._process is not None else None

    def adopt(self, pid: int) -> None:
        """Use a process that runs already as the first one. Does nothing if it has exited."""
        with contextlib.suppress(ProcessLookupError):
            self._process = self._adopted = AdoptedProcess(pid)

    async def start(self) -> None:
        """Start the process, and restart it whenever it exits."""
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
        try:
            process, self._adopted = self._adopted or await self._spawn(), None
        except OSError as error:
            logger.warning("the %s could not be started: %s", self._title, error)
            return None
        self._process = process
        status = await process.wait()
        logger.warning("the %s exited with status %s", self._title, status)
        return status

    async def _spawn(self) -> Process:
        spare = self._spares.take() if self._spares is not None else None
        process = spare or await start_process(self._command, self._environment)
        if process.stdin is None:
            raise RuntimeError("the process has no standard input")
        # uvloop raises where the process has exited already; that is seen, and logged, when its end is awaited.
        with contextlib.suppress(RuntimeError):
            process.stdin.write(msgspec.json.encode(self._config))
            process.stdin.close()
        self._started(process.pid)
        return process

    def kill(self) -> None:
        """Kill the frozen process with all its child processes; it is restarted."""
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)

    async def stop(self) -> None:
        """Stop the process; kill it with all its child processes if it does not exit by itself."""
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
            logger.warning("the %s did not exit within its time limit and is killed", self._title)
            self.kill()
            await process.wait()
