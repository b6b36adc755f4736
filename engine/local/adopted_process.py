"""Process that was not started by this one, with the interface of ``asyncio.subprocess.Process``."""

import asyncio
import os
import signal

UNKNOWN = 255
"""Exit status of a process that is not our child: it cannot be read."""


class AdoptedProcess:
    """Watches a process; created within an event loop.

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
