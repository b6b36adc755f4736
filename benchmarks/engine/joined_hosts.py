"""Machines that join a cloud on this host by ``ppaas machine join``, with the link of remote machines."""

import asyncio
import contextlib
import signal
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

from benchmarks.harness.cloud_under_test import Target
from benchmarks.harness.joining import join, ticket_of
from ppaas.errors import Unavailable

JOIN_TIMEOUT = 60.0
"""Time within which a machine must have joined [s]."""
END_TIMEOUT = 10.0
"""Time within which a machine must exit after SIGTERM [s]."""


class JoinedAgent:
    """The agent process of a joined machine.

    Parameters
    ----------
    name : str
        Name of the machine.
    process : Process
        The process of ``ppaas machine join``, which becomes the agent.
    """

    def __init__(self, name: str, process: asyncio.subprocess.Process) -> None:
        self.name = name
        self._process = process

    def kill(self) -> None:
        """Kill the agent; its containers and its router exit with it."""
        self._process.kill()

    def freeze(self) -> None:
        """Stop the agent by SIGSTOP."""
        self._process.send_signal(signal.SIGSTOP)

    async def end(self) -> None:
        """End the agent by SIGTERM, or kill it if it does not exit."""
        with contextlib.suppress(ProcessLookupError):
            self._process.terminate()
            self._process.send_signal(signal.SIGCONT)
        try:
            await asyncio.wait_for(self._process.wait(), END_TIMEOUT)
        except TimeoutError:
            self._process.kill()
            await self._process.wait()

    async def is_in(self, target: Target) -> None:
        """Wait until the machine has joined the cloud.

        Raises
        ------
        Unavailable
            The process exited, or the machine did not join within the time limit.
        """
        deadline = asyncio.get_running_loop().time() + JOIN_TIMEOUT
        while self.name not in [view["id"] for view in await target.rest.items("/v1/machines")]:
            if self._process.returncode is not None or asyncio.get_running_loop().time() > deadline:
                raise Unavailable(f"machine {self.name!r} did not join: status {self._process.returncode}")
            await asyncio.sleep(0.05)


class LocalHosts:
    """Provides additional machines on this host.

    Parameters
    ----------
    arguments : tuple of str
        Arguments of the cloud; those that allow machines to join are added.
    """

    def __init__(self, arguments: tuple[str, ...]) -> None:
        self.arguments = (*arguments, "--listen-machines", "127.0.0.1:0")
        self.environment: dict[str, str] = {}
        self._count = 0

    @contextlib.asynccontextmanager
    async def joined(self, target: Target, folder: Path) -> AsyncIterator[JoinedAgent]:
        """Start a machine that joins the cloud with this folder by a ticket, and end it afterwards."""
        self._count += 1
        name = f"bench-{self._count}"
        with tempfile.TemporaryDirectory(prefix="m-", ignore_cleanup_errors=True) as own:  # sockets need a short path
            process = await join(name, Path(own), await ticket_of(folder / "data"))
            machine = JoinedAgent(name, process)
            try:
                await machine.is_in(target)
                yield machine
            finally:
                await machine.end()
