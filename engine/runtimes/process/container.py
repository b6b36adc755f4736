"""The process of one container, watched by its agent."""

import asyncio
import os
import signal
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.popen_forkserver import Popen
from pathlib import Path

from engine.runtimes.fork_server.server import UNKNOWN_STATUS
from engine.runtimes.process.control_groups import ControlGroups
from engine.specs.containers import Launch

RETRY = 0.01
"""Time between two checks of a dead process that is not our child yet [s]."""


class ForkedContainer:
    """A container process, forked by the fork server.

    Parameters
    ----------
    process : Popen
        The process.
    ended : callable
        Called once with this object, after the process has exited.
    launch : Launch
        The launch that the process was started with.
    groups : ControlGroups
        Control groups that limit the container to its size.
    """

    def __init__(
        self, process: Popen, ended: Callable[["ForkedContainer"], None], launch: Launch, groups: ControlGroups
    ) -> None:
        self._process = process
        self._ended = ended
        self._name = launch.spec.id
        self._groups = groups
        groups.put(process.pid, launch)
        self._pidfd = _pidfd(process.pid)
        loop = asyncio.get_running_loop()
        self._status: asyncio.Future[int] = loop.create_future()
        loop.add_reader(process.sentinel, self._on_end)

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    def kill(self) -> None:
        """Kill it. Does nothing if it has exited."""
        if self._pidfd is not None:
            with suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._pidfd, signal.SIGKILL)

    def layers_grew(self) -> None:
        """Do nothing: the container sees the folder itself."""

    def endpoint_came(self) -> None:
        """Do nothing: the container finds the socket by its name."""

    def resize(self, launch: Launch) -> None:
        """Move all its threads to the CPUs of its new size, and limit it to that size."""
        if self._pidfd is not None:
            move_threads(self.pid, launch.cpus)
            self._groups.resize(launch)

    async def wait(self) -> int:
        """Wait until it exits; return its exit status, negative for a signal, 255 if unknown."""
        return await asyncio.shield(self._status)

    def _on_end(self) -> None:
        loop = asyncio.get_running_loop()
        loop.remove_reader(self._process.sentinel)
        status = self._process.poll()
        if status is not None and status != UNKNOWN_STATUS:
            self._end(status)
            return
        self.kill()  # the fork server died, and the process may still run
        if self._pidfd is None:
            self._end(UNKNOWN_STATUS)
        else:
            loop.add_reader(self._pidfd, self._on_lost, self._pidfd)

    def _on_lost(self, pidfd: int) -> None:
        asyncio.get_running_loop().remove_reader(pidfd)
        self._reap()

    def _reap(self) -> None:
        """Reap the process: it becomes our child as soon as its dead parent has been cleaned up."""
        with suppress(ChildProcessError):
            found, status = os.waitpid(self.pid, os.WNOHANG)
            if found:
                self._end(os.waitstatus_to_exitcode(status))
                return
        if Path(f"/proc/{self.pid}").exists():
            asyncio.get_running_loop().call_later(RETRY, self._reap)
        else:
            self._end(UNKNOWN_STATUS)

    def _end(self, status: int) -> None:
        self._process.close()
        if self._pidfd is not None:
            os.close(self._pidfd)
            self._pidfd = None
        self._groups.remove(self._name)
        self._status.set_result(status)
        self._ended(self)


def _pidfd(pid: int) -> int | None:
    try:
        return os.pidfd_open(pid)
    except ProcessLookupError:
        return None  # it has exited already


def move_threads(pid: int, cpus: tuple[int, ...]) -> None:
    """Restrict all threads of a process to these CPUs. Does nothing if the process has exited.

    A new thread inherits the CPUs of the thread that starts it, so this repeats until it finds no new thread.
    """
    moved: set[int] = set()
    with suppress(ProcessLookupError, FileNotFoundError):
        while new := _threads(pid) - moved:
            for thread in new:
                with suppress(ProcessLookupError):  # the thread has just ended
                    os.sched_setaffinity(thread, cpus)
            moved |= new


def _threads(pid: int) -> set[int]:
    return {int(task.name) for task in Path(f"/proc/{pid}/task").iterdir()}
