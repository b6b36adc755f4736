"""Cloud with joined machines for the chaos bench: all on loopback, each machine with its own folder."""

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
"""Time within which a machine must exit after SIGTERM [s]."""
JOIN_TIMEOUT = 60.0
"""Time within which all machines must have joined [s]."""
BLINK = 0.05
"""Period at which the list of machines is requested [s]."""

RESTART = 0.5
"""Delay before a machine that exited is restarted [s]."""

LINGER = 60.0
"""Time that a clone is kept without its robot [s]: a killed cloud restarts within it, even on a busy computer."""


class SupervisedMachine:
    """A joined machine that is restarted whenever it exits, as by a process supervisor.

    Parameters
    ----------
    folder : Path
        For its log, its key and its temporary files.
    name : str
        Name of the machine.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self._folder = folder
        self._name = name
        self._process: Process | None = None
        self._keeper: asyncio.Task[None] | None = None

    async def start(self, ticket: str) -> None:
        """Join the cloud by a ticket, and restart the machine from then on."""
        self._process = await join(self._name, self._folder, ticket)
        self._keeper = asyncio.create_task(self._keep(self._process))

    async def _keep(self, process: Process) -> None:
        while True:
            await process.wait()
            await asyncio.sleep(RESTART)
            process = self._process = await join(self._name, self._folder)

    async def stop(self) -> None:
        """End the supervision, then the machine by SIGTERM.

        Raises
        ------
        Unavailable
            The machine did not exit, and was killed.
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
            raise Unavailable(f"machine {self._name} did not exit within {STOP_TIMEOUT:g} s after SIGTERM") from error


class ChaosSite:
    """A cloud and its machines.

    Parameters
    ----------
    machines : int
        Number of machines, the cloud's local machine included.
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
        ended = await asyncio.gather(*keepers, *(machine.stop() for machine in self._machines), return_exceptions=True)
        await self._cloud.end()
        wrong = [str(error) for error in ended if isinstance(error, PPaaSError)]
        if self._cloud.status:
            wrong.append(f"the cloud exited with status {self._cloud.status} instead of 0")
        if wrong:
            raise Unavailable("; ".join(wrong))
