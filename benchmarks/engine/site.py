"""Cloud of the engine bench: started on loopback, with machines that join it where they are needed."""

import asyncio
import contextlib
import tempfile
from collections.abc import AsyncIterator, Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from benchmarks.engine.options import EngineOptions
from benchmarks.harness.cloud_under_test import LINGER, CloudUnderTest, logged_in
from benchmarks.harness.joining import JoinedMachine, joined_machines, ticket_of
from ppaas.clock import monotonic
from ppaas.errors import NotFound, Unavailable
from robots.client.cloud_url import path_of
from robots.demo.cloud_process import CloudProcess

SPARE = 16
"""Containers that the quota allows beyond those of the capacity bench."""


JOIN_TIMEOUT = 60.0
"""Time within which a machine must have joined [s]: long, as Ray starts slowly."""


class SecondMachine(Protocol):
    """A joined machine that the bench can kill or stop."""

    name: str

    def kill(self) -> None:
        """Kill its processes, as a power failure would."""
        ...

    def freeze(self) -> None:
        """Stop its processes by SIGSTOP."""
        ...


class Hosts(Protocol):
    """Provider of additional machines."""

    arguments: tuple[str, ...]
    """Arguments of the cloud that they join."""

    environment: dict[str, str]
    """Environment variables of that cloud."""

    def joined(self, target: CloudUnderTest, folder: Path) -> contextlib.AbstractAsyncContextManager[SecondMachine]:
        """Start a machine that joins the cloud with this folder, and end it afterwards."""
        ...


@dataclass(frozen=True, slots=True)
class EngineSite:
    """A cloud that the bench has started.

    Parameters
    ----------
    target : CloudUnderTest
        The cloud.
    machine : str
        Name of its first machine.
    folder : Path
        Folder of its files.
    hosts : Hosts
        Provider of a second machine.
    """

    target: CloudUnderTest
    machine: str
    folder: Path
    hosts: Hosts

    def second_machine(self) -> contextlib.AbstractAsyncContextManager[SecondMachine]:
        """Start a second machine, and end it afterwards."""
        return self.hosts.joined(self.target, self.folder)

    @contextlib.asynccontextmanager
    async def only_on(self, machine: str) -> AsyncIterator[None]:
        """Place all containers that are opened within the block on one machine."""
        others = [view for view in await self.target.rest.items("/v1/machines") if view["id"] != machine]
        for other in others:
            await self.limit(other["id"], max_containers=0)
        try:
            yield
        finally:
            for other in others:
                await self.limit(other["id"], max_containers=other["max_containers"])

    async def limit(self, machine: str, **settings: float) -> None:
        """Set limits of a machine."""
        await self.target.rest.patch(path_of("machines", machine), settings)

    async def containers(self, prefix: str = "") -> list[dict[str, Any]]:
        """Return the containers of the robots whose names begin with ``prefix``."""
        listed = await self.target.rest.items("/v1/containers")
        return [view for view in listed if (view["robot"] or "").startswith(prefix)]

    async def container(self, robot: str) -> dict[str, Any]:
        """Return the container of a robot.

        Raises
        ------
        NotFound
            The robot has no container.
        """
        for view in await self.containers(robot):
            if view["robot"] == robot:
                return view
        raise NotFound("container of robot", robot)


@contextlib.asynccontextmanager
async def cloud_on(hosts: Hosts, options: EngineOptions) -> AsyncIterator[EngineSite]:
    """Start a cloud with a first machine, and end it afterwards.

    Raises
    ------
    Unavailable
        The cloud does not start.
    """
    most = options.containers + SPARE
    quotas = ("--quota", f"containers={most}", "--quota", f"cores={most}", "--quota", f"robots={10 * most}")
    arguments = ("--linger", str(LINGER), *quotas, *hosts.arguments)
    async with CloudProcess(arguments=arguments, environment=hosts.environment) as cloud:
        target = await logged_in(cloud)
        yield EngineSite(target, (await machines_beyond(target, ()))[0], cloud.folder, hosts)


async def machines_beyond(target: CloudUnderTest, known: Collection[str]) -> list[str]:
    """Wait until machines other than the known ones have joined; return their names.

    Raises
    ------
    Unavailable
        No machine joins within the time limit.
    """
    deadline = monotonic() + JOIN_TIMEOUT
    while monotonic() < deadline:
        there = [name for name in await joined_machines(target.rest) if name not in known]
        if there:
            return there
        await asyncio.sleep(0.05)
    raise Unavailable(f"no machine joined within {JOIN_TIMEOUT:g} s")


# -- machines that join a cloud on this host by ``ppaas machine join``, with the link of remote machines ---------------


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
    async def joined(self, target: CloudUnderTest, folder: Path) -> AsyncIterator[JoinedMachine]:
        """Start a machine that joins the cloud with this folder by a ticket, and end it afterwards."""
        self._count += 1
        name = f"bench-{self._count}"
        with tempfile.TemporaryDirectory(prefix="m-", ignore_cleanup_errors=True) as own:  # sockets need a short path
            machine = await JoinedMachine.start(name, Path(own), await ticket_of(folder / "data"))
            try:
                await machine.is_in(target.rest)
                yield machine
            finally:
                with contextlib.suppress(Unavailable):  # it did not exit by itself, and was killed
                    await machine.end()
