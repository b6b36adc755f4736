"""The process of one container, as its agent sees it."""

import asyncio
import os
import signal
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.popen_forkserver import Popen
from pathlib import Path

from engine.runtimes.fork_server.server import UNHEARD
from engine.runtimes.process.affinity import move_threads
from engine.runtimes.process.control_groups import ControlGroups
from engine.specs.containers import Launch

RETRY = 0.01
"""Seconds between two looks at a process that is dead and not yet ours."""


class ForkedContainer:
    """A process that the fork server forked.

    Parameters
    ----------
    process : Popen
        That was started.
    gone : callable
        Told once, when the process is.
    launch : Launch
        What it was told.
    groups : ControlGroups
        That hold it to its size.
    """

    def __init__(
        self, process: Popen, gone: Callable[["ForkedContainer"], None], launch: Launch, groups: ControlGroups
    ) -> None:
        self._process = process
        self._gone = gone
        self._name = launch.spec.id
        self._groups = groups
        groups.put(process.pid, launch)
        self._pidfd = _pidfd(process.pid)
        loop = asyncio.get_running_loop()
        self._status: asyncio.Future[int] = loop.create_future()
        loop.add_reader(process.sentinel, self._on_end)

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    def kill(self) -> None:
        """End it by force; nothing happens where it is gone."""
        if self._pidfd is not None:
            with suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._pidfd, signal.SIGKILL)

    def layers_grew(self) -> None:
        """Do nothing: it sees the folder itself."""

    def endpoint_came(self) -> None:
        """Do nothing: it finds the socket by its name."""

    def resize(self, launch: Launch) -> None:
        """Let all its threads run on the CPUs of its new size, and hold it to that."""
        if self._pidfd is not None:
            move_threads(self.pid, launch.cpus)
            self._groups.resize(launch)

    async def wait(self) -> int:
        """Return its exit status when it is gone, negative for the signal that killed it, 255 where nobody knows."""
        return await asyncio.shield(self._status)

    def _on_end(self) -> None:
        loop = asyncio.get_running_loop()
        loop.remove_reader(self._process.sentinel)
        status = self._process.poll()
        if status is not None and status != UNHEARD:
            self._end(status)
            return
        self.kill()  # the fork server died, and the process may live on
        if self._pidfd is None:
            self._end(UNHEARD)
        else:
            loop.add_reader(self._pidfd, self._on_lost, self._pidfd)

    def _on_lost(self, pidfd: int) -> None:
        asyncio.get_running_loop().remove_reader(pidfd)
        self._bury()

    def _bury(self) -> None:
        """Take the status of a process that becomes our child now, or soon, when its parent has quite died."""
        with suppress(ChildProcessError):
            found, status = os.waitpid(self.pid, os.WNOHANG)
            if found:
                self._end(os.waitstatus_to_exitcode(status))
                return
        if Path(f"/proc/{self.pid}").exists():
            asyncio.get_running_loop().call_later(RETRY, self._bury)
        else:
            self._end(UNHEARD)

    def _end(self, status: int) -> None:
        self._process.close()
        if self._pidfd is not None:
            os.close(self._pidfd)
            self._pidfd = None
        self._groups.remove(self._name)
        self._status.set_result(status)
        self._gone(self)


def _pidfd(pid: int) -> int | None:
    try:
        return os.pidfd_open(pid)
    except ProcessLookupError:
        return None  # it is gone already
