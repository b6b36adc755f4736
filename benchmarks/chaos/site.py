"""A cloud with machines of other hosts, as far as it can tell: all on loopback, each with a folder of its own."""

import asyncio
import contextlib
import signal
from asyncio.subprocess import Process
from pathlib import Path
from types import TracebackType
from typing import Self

from benchmarks.chaos.cloud_processes import MACHINES
from benchmarks.harness.cloud_under_test import Target, logged_in
from benchmarks.harness.free_ports import free_ports
from benchmarks.harness.joining import join, ticket_of
from ppaas.errors import PPaaSError, Unavailable
from robots.client.rest import RestClient
from robots.demo.cloud_process import CloudProcess

STOP_TIMEOUT = 20.0
JOIN_TIMEOUT = 60.0
BLINK = 0.05

RESTART = 0.5
"""Seconds after which a machine that died is started again."""

LINGER = 60.0
"""Seconds for which a robot's clone is kept: a cloud that is killed is back within them on a busy computer too."""


class SupervisedMachine:
    """A machine that has a ticket; whenever it dies it is started again, as a supervisor does it.

    Parameters
    ----------
    folder : Path
        For its log, its key and its temporary files.
    name : str
        Of the machine.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self._folder = folder
        self._name = name
        self._process: Process | None = None
        self._keeper: asyncio.Task[None] | None = None

    async def start(self, ticket: str) -> None:
        """Join, and stay."""
        self._process = await join(self._name, self._folder, ticket)
        self._keeper = asyncio.create_task(self._keep(self._process))

    async def _keep(self, process: Process) -> None:
        while True:
            await process.wait()
            await asyncio.sleep(RESTART)
            process = self._process = await join(self._name, self._folder)

    async def stop(self) -> None:
        """Start it no more, and end it in order.

        Raises
        ------
        Unavailable
            It did not end, and was killed.
        """
        if self._keeper is None or self._process is None:
            return
        self._keeper.cancel()
        await asyncio.gather(self._keeper, return_exceptions=True)
        if self._process.returncode is not None:
            return
        self._process.send_signal(signal.SIGTERM)
        try:
            async with asyncio.timeout(STOP_TIMEOUT):
                await self._process.wait()
        except TimeoutError as error:
            self._process.kill()
            raise Unavailable(f"machine {self._name} did not end within {STOP_TIMEOUT:g} s of SIGTERM") from error


class ChaosSite:
    """The cloud and its machines.

    Parameters
    ----------
    machines : int
        How many, the cloud's own included.
    """

    def __init__(self, machines: int) -> None:
        listen = ("--listen-machines", f"127.0.0.1:{free_ports(2)[0]}") if machines > 1 else ()
        self._cloud = CloudProcess(arguments=("--port", str(free_ports(1)[0]), "--linger", f"{LINGER:g}", *listen))
        self._machines = [self._machine(f"m{number}") for number in range(2, machines + 1)]
        self._closing = False
        self._keeper: asyncio.Task[None] | None = None
        self.restarts = 0

    def _machine(self, name: str) -> SupervisedMachine:
        return SupervisedMachine(self.folder / MACHINES / name, name)

    @property
    def folder(self) -> Path:
        """Where all of it keeps its files."""
        return self._cloud.folder

    async def __aenter__(self) -> Self:
        """Start all of it, and wait until all machines are in.

        Raises
        ------
        Unavailable
            Something did not come up.
        """
        await self._cloud.__aenter__()
        try:
            self._keeper = asyncio.create_task(self._keep())
            for machine in self._machines:
                await machine.start(await ticket_of(self.folder / "data"))
            await self._all_in((await self.login()).rest)
        except BaseException:
            await self.__aexit__(None, None, None)
            raise
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End what still runs, and remove the folder."""
        with contextlib.suppress(Unavailable):  # who wants to know stops it before
            await self.stop()
        await self._cloud.__aexit__(kind, error, trace)

    async def _keep(self) -> None:
        """Start the cloud again on the same data, whenever it dies."""
        while True:
            await self._cloud.ended()
            await self._cloud.again()
            self.restarts += 1

    async def login(self) -> Target:
        """Return the cloud as its administrator has it."""
        return await logged_in(self._cloud)

    async def _all_in(self, rest: RestClient) -> None:
        wanted = len(self._machines) + 1
        try:
            async with asyncio.timeout(JOIN_TIMEOUT):
                while len(await rest.items("/v1/machines")) < wanted:  # noqa: ASYNC110 - the cloud tells nobody
                    await asyncio.sleep(BLINK)
        except TimeoutError as error:
            raise Unavailable(f"not all of {wanted} machines were in the cloud within {JOIN_TIMEOUT:g} s") from error

    async def stop(self) -> None:
        """End all of it in order; what it kept stays.

        Raises
        ------
        Unavailable
            A part did not end in order, or the cloud did not come up again.
        """
        keepers = [self._keeper] if self._keeper is not None else []
        for keeper in keepers:
            keeper.cancel()
        ended = await asyncio.gather(*keepers, *(machine.stop() for machine in self._machines), return_exceptions=True)
        await self._cloud.end()
        wrong = [str(error) for error in ended if isinstance(error, PPaaSError)]
        if self._cloud.status:
            wrong.append(f"the cloud ended with status {self._cloud.status}, not in order")
        if wrong:
            raise Unavailable("; ".join(wrong))
