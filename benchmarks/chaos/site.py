"""Cloud with joined machines for the chaos bench: all on loopback, each machine with its own folder."""

import asyncio
import contextlib
from pathlib import Path
from types import TracebackType
from typing import Self

from benchmarks.chaos.cloud_processes import MACHINES, STANDBY
from benchmarks.harness.cloud_under_test import CloudUnderTest
from benchmarks.harness.free_ports import free_ports
from benchmarks.harness.front import Front
from benchmarks.harness.joining import BLINK, JoinedMachine, joined_machines, ticket_of
from engine.remote.replica import LAST
from ppaas.errors import PPaaSError, Unavailable
from robots.client.rest import RestClient
from robots.demo.cloud_process import CloudProcess

JOIN_TIMEOUT = 60.0
"""Time within which all machines must have joined, and a standby must be connected [s]."""

LINGER = 60.0
"""Time that a clone is kept without its robot [s]: a killed cloud restarts within it, even on a busy computer."""

ENDPOINTS = "2"
"""Number of endpoint processes of each cloud process."""

AWAY = 5.0
"""Time after which a cloud process that has exited is started again as a standby [s]: the other one leads by then."""


class ChaosSite:
    """A cloud and its machines, with a proxy before the processes that may lead.

    Parameters
    ----------
    machines : int
        Number of machines, the cloud's local machine included. A standby has a local machine of its own besides.
    standby : bool
        Whether a second cloud process stands by. Both share the stores; the one that exits stands by afterwards.
    """

    def __init__(self, machines: int, *, standby: bool) -> None:
        self._ports = free_ports(2)
        self._leader = CloudProcess()
        self._clouds = [self._leader]
        listens = machines > 1
        self._leader.arguments = self._arguments(self._ports[0], listens=listens)
        if standby:
            folder = self.folder / MACHINES / STANDBY / "t"
            self._clouds.append(CloudProcess(folder=folder, arguments=self._arguments(self._ports[1], listens=listens)))
        ports = free_ports(machines - 1)
        self._joined = {f"m{number}": port for number, port in enumerate(ports, 2)}
        self._machines: list[JoinedMachine] = []
        self._keepers: list[asyncio.Task[None]] = []
        self._front = Front(self._ports[: len(self._clouds)], ports)
        self._open = contextlib.AsyncExitStack()
        self.restarts = 0

    def _arguments(self, port: int, *, listens: bool) -> list[str]:
        files = self.folder / "data"
        found = ["--port", str(port), "--linger", f"{LINGER:g}", "--endpoints", ENDPOINTS]
        found += ["--store", f"sqlite:///{files / 'ppaas.sqlite'}", "--map-store", f"file:///{files / 'maps'}"]
        found += ["--admin-password-file", str(self.folder / "password")]
        return [*found, "--listen-machines", f"127.0.0.1:{free_ports(2)[0]}"] if listens else found

    @property
    def folder(self) -> Path:
        """Folder of all files of the cloud and its machines."""
        return self._leader.folder

    @property
    def has_standby(self) -> bool:
        """True if a second cloud process stands by."""
        return len(self._clouds) > 1

    @property
    def take_overs(self) -> int:
        """Number of times that the other cloud process became the leader."""
        return self._front.changes

    async def __aenter__(self) -> Self:
        """Start the cloud and its machines, and wait until all have joined.

        Raises
        ------
        Unavailable
            The cloud did not start, or a machine did not join.
        """
        await self._open.enter_async_context(self._leader)
        try:
            await self._open.enter_async_context(self._front.serving())
            await self._front.is_ready()
            for name, port in self._joined.items():
                await self._join(name, port)
            await self._all_in((await self.login()).rest)
            await self._stand_by(*self._clouds[1:])
            self._keepers = [asyncio.create_task(self._keep(cloud)) for cloud in self._clouds]
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
        await self._open.aclose()

    async def _join(self, name: str, port: int) -> None:
        options = ("--endpoints", "1", "--port", str(port))
        ticket, folder = await ticket_of(self.folder / "data"), self.folder / MACHINES / name
        self._machines.append(await JoinedMachine.start(name, folder, ticket, restarts=True, options=options))

    async def _stand_by(self, *standbys: CloudProcess) -> None:
        """Start a standby; if machines have joined, give it a ticket, and wait until it has the leader's files."""
        for standby in standbys:
            standby.folder.mkdir(parents=True)
            ticket = [await ticket_of(self.folder / "data", "--standby", STANDBY)] if self._joined else []
            ordinary = standby.arguments
            standby.arguments = [*ordinary, "--standby", *ticket]
            await standby.begin()
            standby.arguments = ordinary
            if ticket:
                await _appears(standby.folder / "data" / LAST)

    async def _keep(self, cloud: CloudProcess) -> None:
        """Start a cloud process again whenever it exits: on the same data at once, or as a standby of the other one."""
        if self.has_standby:
            cloud.arguments = [*cloud.arguments, "--standby"]
        while True:
            await cloud.ended()
            await asyncio.sleep(AWAY if self.has_standby else 0.0)
            await (cloud.begin() if self.has_standby else cloud.again())
            self.restarts += 1

    async def login(self) -> CloudUnderTest:
        """Log in as the administrator."""
        rest = RestClient(self._front.url)
        login = await rest.login(self._leader.ready.admin_user, self._leader.password)
        return CloudUnderTest(rest, self._front.url, login.token, None)

    async def _all_in(self, rest: RestClient) -> None:
        wanted = len(self._machines) + 1
        try:
            async with asyncio.timeout(JOIN_TIMEOUT):
                while len(await joined_machines(rest)) < wanted:  # noqa: ASYNC110 - the cloud sends no event
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
        for keeper in self._keepers:
            keeper.cancel()
        works = (*self._keepers, *(machine.end() for machine in self._machines))
        ended = await asyncio.gather(*works, return_exceptions=True)
        wrong = [str(error) for error in ended if isinstance(error, PPaaSError)]
        running = [cloud for cloud in self._clouds if cloud.status is None]
        for cloud in running:
            await cloud.end()
            if cloud.status:
                wrong.append(f"the cloud exited with status {cloud.status} instead of 0")
        if wrong:
            raise Unavailable("; ".join(wrong))


async def _appears(file: Path) -> None:
    try:
        async with asyncio.timeout(JOIN_TIMEOUT):
            while not await asyncio.to_thread(file.exists):  # noqa: ASYNC110 - another process writes it
                await asyncio.sleep(BLINK)
    except TimeoutError as error:
        raise Unavailable(f"the standby has not copied the files of its leader within {JOIN_TIMEOUT:g} s") from error
