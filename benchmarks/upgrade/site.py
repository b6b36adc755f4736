"""Cloud that is upgraded while robots drive: a leader, a standby and two machines, each by the Python of a release."""

import asyncio
import contextlib
import signal
from collections.abc import Awaitable, Callable
from functools import partial
from random import Random
from types import TracebackType
from typing import Any, Self

from benchmarks.harness.cloud_under_test import CloudUnderTest
from benchmarks.harness.free_ports import free_ports
from benchmarks.harness.front import Front
from benchmarks.harness.joining import BLINK, INSTALLED, RESTART, JoinedMachine, ticket_of
from engine.remote.replica import LAST
from ppaas.clock import monotonic
from ppaas.errors import PPaaSError, Unavailable
from robots.client.cloud_url import path_of
from robots.client.rest import RestClient
from robots.demo.cloud_process import CloudProcess

MACHINES = ("m2", "m3")
PATIENCE = 90.0
"""Time within which a step of the upgrade is complete [s]."""

STANDS_BY = 4.0
"""Time within which a standby that was started again follows its leader [s]."""

LATEST_KILL = 3.0
"""Latest time after the begin of the drain of a machine, or of the start of a process, at which it is killed [s]."""


class UpgradedSite:
    """A cloud of one release, whose processes are upgraded to another one after another.

    Parameters
    ----------
    before, after : str
        Python interpreters of the releases.
    kills : Random, optional
        Chooses the moments at which the process that is being upgraded is killed, and the new one while it starts;
        None to end it in order.
    """

    def __init__(self, before: str, after: str, kills: Random | None) -> None:
        self._before, self._after, self._kills = before, after, kills
        self._ports = free_ports(2)
        self._leader = CloudProcess(environment=INSTALLED)
        folder = self._leader.folder / "standby" / "t"
        folder.mkdir(parents=True)
        self._standby = CloudProcess(environment=INSTALLED, folder=folder)
        for cloud, port in zip((self._leader, self._standby), self._ports, strict=True):
            cloud.arguments, cloud.python = self._arguments(port), before
        ports = free_ports(len(MACHINES))
        self._joined = dict(zip(MACHINES, ports, strict=True))
        self._machines: list[JoinedMachine] = []
        self._front = Front(self._ports, ports)
        self._open = contextlib.AsyncExitStack()

    def _arguments(self, port: int) -> list[str]:
        data = self._leader.folder / "data"
        found = ["--port", str(port), "--linger", "60", "--admin-password-file", str(self._leader.folder / "password")]
        found += ["--store", f"sqlite:///{data / 'ppaas.sqlite'}", "--map-store", f"file:///{data / 'maps'}"]
        return [*found, "--listen-machines", f"127.0.0.1:{free_ports(2)[0]}"]

    async def __aenter__(self) -> Self:
        """Start all processes of the release before.

        Raises
        ------
        Unavailable
            One does not start.
        """
        await self._open.enter_async_context(self._leader)
        try:
            await self._open.enter_async_context(self._front.serving())
            await self._front.is_ready()
            rest = (await self.login()).rest
            await rest.patch(path_of("machines", "local"), {"max_containers": 0})
            for name in MACHINES:
                await self._join(name, rest)
            ticket = await ticket_of(self._leader.folder / "data", "--standby", "standby")
            ordinary = self._standby.arguments
            self._standby.arguments = [*ordinary, "--standby", ticket]
            await self._standby.begin()
            self._standby.arguments = [*ordinary, "--standby"]
            await _until((self._standby.folder / "data" / LAST).exists, "the standby has no files")
            await asyncio.sleep(STANDS_BY)
        except BaseException:
            await self.__aexit__(None, None, None)
            raise
        return self

    async def _join(self, name: str, rest: RestClient) -> None:
        options = ("--endpoints", "1", "--port", str(self._joined[name]), "--cores", "2")
        ticket = await ticket_of(self._leader.folder / "data")
        machine = await JoinedMachine.start(
            name, self._leader.folder / name, ticket, restarts=True, options=options, python=self._before
        )
        self._machines.append(machine)
        await machine.is_in(rest)

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End all processes."""
        for machine in self._machines:
            with contextlib.suppress(Unavailable):
                await machine.end()
        await self._standby.stop()
        await self._open.aclose()

    async def login(self) -> CloudUnderTest:
        """Log in as the administrator, by the proxy."""
        rest = RestClient(self._front.url)
        login = await rest.login(self._leader.ready.admin_user, self._leader.password)
        return CloudUnderTest(rest, self._front.url, login.token, None)

    # -- the upgrade ---------------------------------------------------------------------------------------------------

    def steps(self, rest: RestClient) -> dict[str, Callable[[], Awaitable[None]]]:
        """Return the steps of the upgrade by name, in the order of docs/upgrading.md."""
        return {
            "standby upgraded": self._upgrade_standby,
            **{f"{one.name} upgraded": partial(self._upgrade_machine, one, rest) for one in self._machines},
            "leader upgraded": partial(self._upgrade_leader, rest),
        }

    async def _upgrade_standby(self) -> None:
        await self._end(self._standby)
        self._standby.python = self._after
        await self._begin(self._standby)
        await asyncio.sleep(STANDS_BY)
        if self._standby.status is not None:
            raise Unavailable(f"the standby ended with status {self._standby.status}; see {self._standby.folder}/log")

    async def _end(self, cloud: CloudProcess) -> None:
        if self._kills is None:
            await cloud.end()
        else:
            cloud.send(signal.SIGKILL)
            await cloud.ended()

    async def _begin(self, cloud: CloudProcess) -> None:
        """Start a process of the new release; if processes are killed, kill it while it starts, and start it again."""
        await cloud.begin()
        if self._kills is not None:
            await asyncio.sleep(self._kills.uniform(0.0, LATEST_KILL))
            await self._end(cloud)
            await cloud.begin()

    async def _upgrade_machine(self, machine: JoinedMachine, rest: RestClient) -> None:
        path, machine.python = path_of("machines", machine.name), self._after
        await _patched(rest, path, draining=True)
        if self._kills is None:
            await _until_listed(rest, machine.name, lambda state: state == "drained", "was not drained")
            machine.terminate()
        else:
            await asyncio.sleep(self._kills.uniform(0.0, LATEST_KILL))
            machine.kill()
            await asyncio.sleep(2.0 * RESTART + self._kills.uniform(0.0, LATEST_KILL))
            machine.kill()  # the new process, which its supervisor starts again
        await _until_listed(rest, machine.name, lambda state: state is None, "has not left")
        await _until_listed(rest, machine.name, lambda state: state not in (None, "starting"), "has not joined again")
        await _patched(rest, path, draining=False)

    async def _upgrade_leader(self, rest: RestClient) -> None:
        changes = self._front.changes
        self._leader.send(signal.SIGUSR1 if self._kills is None else signal.SIGKILL)
        await self._leader.ended()
        await _until(lambda: self._front.changes > changes, "the standby does not lead")
        self._leader.arguments, self._leader.python = [*self._leader.arguments, "--standby"], self._after
        await self._begin(self._leader)
        for name in MACHINES:
            await _until_listed(rest, name, lambda state: state == "ready", "has not found the new leader")


async def _until(check: Callable[[], bool], problem: str) -> None:
    try:
        async with asyncio.timeout(PATIENCE):
            while not check():  # noqa: ASYNC110 - another process does it
                await asyncio.sleep(BLINK)
    except TimeoutError as error:
        raise Unavailable(f"{problem} after {PATIENCE:g} s") from error


async def _until_listed(rest: RestClient, machine: str, check: Callable[[str | None], bool], problem: str) -> None:
    """Wait until the state of a machine, or None if it is not listed, is the wanted one; retry without a master."""
    try:
        async with asyncio.timeout(PATIENCE):
            while True:
                with contextlib.suppress(PPaaSError):
                    states = {one["id"]: one["state"] for one in await rest.items("/v1/machines")}
                    if check(states.get(machine)):
                        return
                await asyncio.sleep(BLINK)
    except TimeoutError as error:
        raise Unavailable(f"machine {machine} {problem} after {PATIENCE:g} s") from error


async def _patched(rest: RestClient, path: str, **change: Any) -> None:
    """Change settings of a machine; again while its cloud is not reachable."""
    end = monotonic() + PATIENCE
    while True:
        try:
            await rest.patch(path, change)
            return
        except PPaaSError:
            if monotonic() > end:
                raise
        await asyncio.sleep(BLINK)
