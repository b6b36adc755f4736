"""The cloud that the engine's bench measures: its own, on loopback, and a second machine where one is needed."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from benchmarks.engine.options import EngineOptions
from benchmarks.harness.cloud_under_test import LINGER, Target, logged_in
from ppaas.clock import monotonic
from ppaas.errors import NotFound, Unavailable
from robots.client.rest_paths import path_of
from robots.demo.cloud_process import CloudProcess

SPARE = 16
"""Containers that a user may have beyond those of the largest crowd."""


JOIN_TIMEOUT = 60.0
"""Seconds in which a machine must have joined: what Ray starts takes its time."""


class SecondMachine(Protocol):
    """A machine that joined, and whose end is in our hands."""

    name: str

    def kill(self) -> None:
        """End it by force, as if its power were cut."""
        ...

    def freeze(self) -> None:
        """Let it stand still."""
        ...


class Hosts(Protocol):
    """Where machines come from."""

    arguments: tuple[str, ...]
    """Of the cloud that takes them."""

    environment: dict[str, str]
    """For that cloud."""

    def joined(self, target: Target, folder: Path) -> contextlib.AbstractAsyncContextManager[SecondMachine]:
        """Let one more machine join the cloud in a folder."""
        ...


@dataclass(frozen=True, slots=True)
class EngineSite:
    """A cloud of the bench's own.

    Parameters
    ----------
    target : Target
        The cloud.
    machine : str
        That it has from the start.
    folder : Path
        Where its files are.
    hosts : Hosts
        Where a second machine comes from.
    """

    target: Target
    machine: str
    folder: Path
    hosts: Hosts

    def second_machine(self) -> contextlib.AbstractAsyncContextManager[SecondMachine]:
        """Let one more machine join; it is gone afterwards."""
        return self.hosts.joined(self.target, self.folder)

    @contextlib.asynccontextmanager
    async def only_on(self, machine: str) -> AsyncIterator[None]:
        """Have what is opened inside placed on one machine."""
        others = [view for view in await self.target.rest.items("/v1/machines") if view["id"] != machine]
        for other in others:
            await self.limit(other["id"], max_containers=0)
        try:
            yield
        finally:
            for other in others:
                await self.limit(other["id"], max_containers=other["max_containers"])

    async def limit(self, machine: str, **settings: float) -> None:
        """Say how much a machine may be given."""
        await self.target.rest.patch(path_of("machines", machine), settings)

    async def containers(self, prefix: str = "") -> list[dict[str, Any]]:
        """Return the containers of the robots whose names begin so."""
        listed = await self.target.rest.items("/v1/containers")
        return [view for view in listed if (view["robot"] or "").startswith(prefix)]

    async def container(self, robot: str) -> dict[str, Any]:
        """Return the container of a robot.

        Raises
        ------
        NotFound
            It has none.
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
        It does not come up.
    """
    most = options.containers + SPARE
    quotas = ("--quota", f"containers={most}", "--quota", f"cores={most}", "--quota", f"robots={10 * most}")
    arguments = ("--linger", str(LINGER), *quotas, *hosts.arguments)
    async with CloudProcess(arguments=arguments, environment=hosts.environment) as cloud:
        target = await logged_in(cloud)
        yield EngineSite(target, (await machines_beyond(target, ()))[0], cloud.folder, hosts)


async def machines_beyond(target: Target, known: Collection[str]) -> list[str]:
    """Return the names of the machines that have joined since, once there is one.

    Raises
    ------
    Unavailable
        None joins.
    """
    deadline = monotonic() + JOIN_TIMEOUT
    while monotonic() < deadline:
        there = [view["id"] for view in await target.rest.items("/v1/machines") if view["id"] not in known]
        if there:
            return there
        await asyncio.sleep(0.05)
    raise Unavailable(f"no machine joined within {JOIN_TIMEOUT:g} s")
