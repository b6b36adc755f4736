"""The fork server of the standard library, driven from an event loop."""

import asyncio
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing.popen_forkserver import Popen
from types import ModuleType
from typing import TypeVar

from engine.processes.heartbeats import BEAT_PERIOD, MISSED
from engine.runtimes.entries import Entry
from engine.runtimes.fork_server import early_start
from engine.runtimes.fork_server.child import ServerReport, probe
from ppaas.clock import monotonic
from ppaas.errors import Unavailable

T = TypeVar("T")

UNKNOWN_STATUS = 255
"""Exit status of a process whose fork server died before it could report one."""

_context = multiprocessing.get_context("forkserver")
_main_lock = threading.Lock()
_warm: list["ForkServer"] = []  # in the order in which they became warm; the last one watches the running server

PROBE_TIMEOUT = 600.0
"""Time limit for the fork server to become warm [s]. The first start on a machine compiles all kernels."""

ENDING_TIMEOUT = 5.0
"""Time limit for a fork server that no longer listens to exit [s]."""

FORK_TIMEOUT = MISSED * BEAT_PERIOD
"""Time limit for a warm fork server to fork [s]; a frozen one never does. All other heartbeats have the same limit.
A fork takes 0.05 s, and tenths of a second on a busy machine. The next server must be warm before the master gives up
the requested container."""


def start_process(target: Callable[..., None], *arguments: object) -> Popen:
    """Start a process from the fork server; blocks until it has forked.

    The ``sentinel`` of the process becomes readable when it exits; then ``poll`` returns its exit status, or
    ``UNKNOWN_STATUS`` if the server died before. Its ``close`` kills a process that still runs.

    Raises
    ------
    EOFError, OSError
        The server died meanwhile.
    """
    deadline = monotonic() + ENDING_TIMEOUT
    while True:
        try:
            # ``Process.start`` would poll, in this thread, processes that an event loop polls.
            with _without_main_module():
                return Popen(_context.Process(target=target, args=arguments))
        except ConnectionRefusedError:  # by a server that is about to exit, so the library does not start another yet
            if monotonic() > deadline:
                raise
            time.sleep(0.02)


async def fork(target: Callable[..., None], *arguments: object) -> Popen:
    """Start a process, as ``start_process`` does, from the running fork server or from a new one.

    A warm server that does not fork in time is frozen: it is killed, and a new one is used.

    Raises
    ------
    EOFError, OSError
        The servers died, or were killed.
    """
    if _warm:
        with suppress(EOFError, OSError):
            return await _warm[-1].fork(target, *arguments)
    return await asyncio.to_thread(
        start_process, target, *arguments
    )  # it may have to import modules first: no time-out


class ForkServer:
    """Starts processes by fork.

    Its blocking calls run one at a time in a thread. There is one fork server per process: all objects of this class
    share it.

    Parameters
    ----------
    entry : Entry
        Function that the processes run, and the modules that the server imports before it forks them.
    """

    def __init__(self, entry: Entry) -> None:
        self._entry = entry
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="fork")
        self._pidfd: int | None = None

    @property
    def is_warm(self) -> bool:
        """Whether it became warm and its death has not been noticed."""
        return self._pidfd is not None

    async def warm(self, died: Callable[[], None]) -> ServerReport:
        """Start the server if none runs, and wait until it has imported everything.

        Parameters
        ----------
        died : callable
            Called on the loop if it dies from now on.

        Raises
        ------
        Unavailable
            The server exited, could not import the modules of containers, or took too long.
        """
        early_start.choose(self._entry.of_fork_server)
        try:
            answer = await self._call(self._probe, PROBE_TIMEOUT)
            if isinstance(answer, str):
                raise Unavailable(f"containers cannot start from the fork server: {answer}")
            self.forget()
            self._pidfd = os.pidfd_open(answer.pid)
            _warm.append(self)
        except (EOFError, OSError) as error:
            raise Unavailable("the fork server exited during its imports; see its error output") from error
        asyncio.get_running_loop().add_reader(self._pidfd, died)
        return answer

    def _probe(self) -> ServerReport | str:
        receiving, sending = _context.Pipe(duplex=False)
        with receiving, sending:
            process = start_process(probe, self._entry.function, sending)
            sending.close()
            try:
                answer: ServerReport | str = receiving.recv()
            finally:
                process.wait()
                process.close()
        return answer

    async def fork(self, target: Callable[..., None], *arguments: object) -> Popen:
        """Start a process, as ``start_process`` does.

        Raises
        ------
        EOFError, OSError
            The server is dead, or was killed because it took too long.
        """
        return await self._call(lambda: start_process(target, *arguments), FORK_TIMEOUT)

    async def _call(self, blocking: Callable[[], T], timeout: float) -> T:
        try:
            async with asyncio.timeout(timeout):
                return await asyncio.get_running_loop().run_in_executor(self._thread, blocking)
        except TimeoutError:
            self.kill()  # unblocks the thread
            raise

    def kill(self) -> None:
        """Kill the server."""
        if self._pidfd is not None:
            with suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._pidfd, signal.SIGKILL)

    async def end(self) -> None:
        """Kill the server and wait until it is dead."""
        if self._pidfd is None:
            return
        self.kill()
        loop = asyncio.get_running_loop()
        dead = asyncio.Event()
        loop.add_reader(self._pidfd, dead.set)
        await dead.wait()
        self.forget()

    def forget(self) -> None:
        """Stop watching the server; if it is dead, the next ``warm`` starts another."""
        if self._pidfd is not None:
            asyncio.get_running_loop().remove_reader(self._pidfd)
            os.close(self._pidfd)
            self._pidfd = None
            _warm.remove(self)

    def close(self) -> None:
        """Stop making calls. The server itself ends with this process."""
        self.forget()
        self._thread.shutdown(wait=False)


@contextmanager
def _without_main_module() -> Iterator[None]:
    # A child would import the main module of its parent, such as a command-line program. Ours do not need it.
    with _main_lock:
        main = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            yield
        finally:
            sys.modules["__main__"] = main
