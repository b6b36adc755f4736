"""Cloud with joined machines for the chaos bench: all on loopback, each machine with its own folder."""

import asyncio
import contextlib
from pathlib import Path
from types import TracebackType
from typing import Self

from benchmarks.chaos.cloud_processes import MACHINES
from benchmarks.harness.cloud_under_test import Target, logged_in
from benchmarks.harness.free_ports import free_ports
from benchmarks.harness.joining import BLINK, JoinedMachine, ticket_of
from ppaas.errors import PPaaSError, Unavailable
from robots.client.rest import RestClient
from robots.demo.cloud_process import CloudProcess

JOIN_TIMEOUT = 60.0
"""Time within which all machines must have joined [s]."""

LINGER = 60.0
"""Time that a clone is kept without its robot [s]: a killed cloud restarts within it, even on a busy computer."""

ENDPOINTS = "2"
"""Number of endpoint processes."""


class ChaosSite:
    """A cloud and its machines.

    Parameters
    ----------
    machines : int
        Number of machines, the cloud's local machine included.
    """

    def __init__(self, machines: int) -> None:
        listen = ("--listen-machines", f"127.0.0.1:{free_ports(2)[0]}") if machines > 1 else ()
        self._cloud = CloudProcess(
            arguments=("--port", str(free_ports(1)[0]), "--linger", f"{LINGER:g}", "--endpoints", ENDPOINTS, *listen)
        )
        self._names = [f"m{number}" for number in range(2, machines + 1)]
        self._machines: list[JoinedMachine] = []
        self._closing = False
        self._keeper: asyncio.Task[None] | None = None
        self.restarts = 0

    @property
    def folder(self) -> Path:
        """Folder of all files of the cloud and its machines."""
        return self._cloud.folder

    async def __aenter__(self) -> Self:
        """Start the cloud and its machines, and wait until all have joined.

        Raises
        ------
        Unavailable
            The cloud did not start, or a machine did not join.
        """
        await self._cloud.__aenter__()
        try:
            self._keeper = asyncio.create_task(self._keep())
            for name in self._names:
                ticket = await ticket_of(self.folder / "data")
                machine = await JoinedMachine.start(name, self.folder / MACHINES / name, ticket, restarts=True)
                self._machines.append(machine)
            await self._all_in((await self.login()).rest)
        except BaseException:
            await self.__aexit__(None, None, None)
            raise
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End all processes that still run, and remove the folder."""
        with contextlib.suppress(Unavailable):  # a caller that checks it calls stop() before
            await self.stop()
        await self._cloud.__aexit__(kind, error, trace)

    async def _keep(self) -> None:
        """Restart the cloud on the same data whenever it exits."""
        while True:
            await self._cloud.ended()
            await self._cloud.again()
            self.restarts += 1

    async def login(self) -> Target:
        """Log in as the administrator."""
        return await logged_in(self._cloud)

    async def _all_in(self, rest: RestClient) -> None:
        wanted = len(self._machines) + 1
        try:
            async with asyncio.timeout(JOIN_TIMEOUT):
                while len(await rest.items("/v1/machines")) < wanted:  # noqa: ASYNC110 - the cloud sends no event
                    await asyncio.sleep(BLINK)
        except TimeoutError as error:
            raise Unavailable(f"not all {wanted} machines joined the cloud within {JOIN_TIMEOUT:g} s") from error

    async def stop(self) -> None:
        """End the machines and the cloud in order; their files stay.

        Raises
        ------
        Unavailable
            A process did not exit in order, or the cloud could not be restarted.
        """
        keepers = [self._keeper] if self._keeper is not None else []
        for keeper in keepers:
            keeper.cancel()
        ended = await asyncio.gather(*keepers, *(machine.end() for machine in self._machines), return_exceptions=True)
        await self._cloud.end()
        wrong = [str(error) for error in ended if isinstance(error, PPaaSError)]
        if self._cloud.status:
            wrong.append(f"the cloud exited with status {self._cloud.status} instead of 0")
        if wrong:
            raise Unavailable("; ".join(wrong))
