"""Machines that join a cloud on this host by ``ppaas machine join``, over the links of machines of other hosts."""

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
END_TIMEOUT = 10.0


class JoinedAgent:
    """The process of a machine; ``ppaas machine join`` becomes its agent.

    Parameters
    ----------
    name : str
        Of the machine.
    process : Process
        That was started.
    """

    def __init__(self, name: str, process: asyncio.subprocess.Process) -> None:
        self.name = name
        self._process = process

    def kill(self) -> None:
        """End the agent by force; its containers and its router end with it."""
        self._process.kill()

    def freeze(self) -> None:
        """Let the agent stand still."""
        self._process.send_signal(signal.SIGSTOP)

    async def end(self) -> None:
        """End it in order, or by force where it stands still or does not go."""
        with contextlib.suppress(ProcessLookupError):
            self._process.terminate()
            self._process.send_signal(signal.SIGCONT)
        try:
            await asyncio.wait_for(self._process.wait(), END_TIMEOUT)
        except TimeoutError:
            self._process.kill()
            await self._process.wait()

    async def is_in(self, target: Target) -> None:
        """Wait until the cloud has it.

        Raises
        ------
        Unavailable
            It ended before, or takes too long.
        """
        deadline = asyncio.get_running_loop().time() + JOIN_TIMEOUT
        while self.name not in [view["id"] for view in await target.rest.items("/v1/machines")]:
            if self._process.returncode is not None or asyncio.get_running_loop().time() > deadline:
                raise Unavailable(f"machine {self.name!r} did not join: status {self._process.returncode}")
            await asyncio.sleep(0.05)


class LocalHosts:
    """This host, as if it were several.

    Parameters
    ----------
    arguments : tuple of str
        Of the cloud, beside those that let machines join.
    """

    def __init__(self, arguments: tuple[str, ...]) -> None:
        self.arguments = (*arguments, "--listen-machines", "127.0.0.1:0")
        self.environment: dict[str, str] = {}
        self._count = 0

    @contextlib.asynccontextmanager
    async def joined(self, target: Target, folder: Path) -> AsyncIterator[JoinedAgent]:
        """Let a machine join the cloud whose files are in a folder, by a ticket."""
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
