"""A process that somebody else started, as ``asyncio`` has one that we started."""

import asyncio
import os
import signal

UNKNOWN = 255
"""Status of a process that is no child of ours: nobody tells it."""


class AdoptedProcess:
    """Watches a process; made within a loop.

    Parameters
    ----------
    pid : int
        Of the process.

    Raises
    ------
    ProcessLookupError
        It has ended.
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
        """Return its status when it has ended."""
        await self._ended.wait()
        return UNKNOWN

    def terminate(self) -> None:
        """Ask it to end."""
        if self.returncode is None:
            signal.pidfd_send_signal(self._pidfd, signal.SIGTERM)
