"""Endpoint: connects the web application with the master and with the containers of its clients."""

import asyncio
import contextlib
import logging
import os
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import psutil

from engine.endpoint.cloud import EndpointCloud
from engine.endpoint.link_listener import LinkListener, MachineAccess
from engine.endpoint.master_link import MasterLink
from engine.endpoint.places import EndpointPlaces
from engine.endpoint.sessions import EndpointSessions
from engine.master.quotas import Quota, Quotas
from engine.processes.background import Background, repeat
from engine.protocols.address import Address
from engine.protocols.endpoint_sockets import endpoint_socket
from engine.protocols.refusals import Refusal, error_of
from engine.service.endpoints.interface import EndpointState, MasterCalls, Registration
from engine.service.news.news import Hear, NewsKind
from engine.service.news.robot_facts import AskFact, FactKind
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

PERIOD = 1.0
"""Interval of reports to the master [s]."""

START_PATIENCE = 60.0
"""Time within which a new endpoint reaches the master [s]."""

SILENCE = 1.0
"""Time within which the master answers a report [s]."""

Displace = Callable[[str, str, str | None], Awaitable[None]]
"""Displaces the socket of a user's robot, if it is dead or of the named session."""

Load = Callable[[], tuple[int, float]]
"""Returns the number of sockets, and the frames of clients since the last call [1/s]."""

Replaced = Callable[[], Awaitable[bool]]
"""Returns whether another master leads."""


@dataclass(frozen=True, slots=True)
class MasterAddress:
    """Address of the master, and the secret of the cloud's own processes."""

    where: Callable[[], Address]
    secret: str


async def _knows_nothing(_kind: FactKind, _user: str, _robot: str) -> bytes | None:
    return None


class Endpoint:
    """The engine's part of an endpoint process.

    Parameters
    ----------
    name : str
        Name of the endpoint, unique in the cloud.
    master : MasterAddress
    quota : Quota
        Quota of users without own limits.
    run_dir : Path
        Folder for the socket that containers dial.
    machine : str
        Machine on which it runs.
    url : str
        Address at which clients reach it.
    displace : callable
        Displaces the socket of a robot that connects at another endpoint.
    load : callable
        Returns the number of sockets, and the frames of clients since the last call [1/s].
    machines : MachineAccess, optional
        Access for containers of other hosts; None for none.

    Attributes
    ----------
    master : MasterLink
    cloud : EndpointCloud
    sessions : EndpointSessions
    """

    def __init__(
        self,
        name: str,
        master: MasterAddress,
        quota: Quota,
        run_dir: Path,
        *,
        machine: str,
        url: str,
        displace: Displace,
        load: Load,
        machines: MachineAccess | None = None,
    ) -> None:
        self._places = EndpointPlaces()
        self._listener = LinkListener(endpoint_socket(run_dir, name), self._places.link, machines)
        self._name, self._secret, self._machine, self._url = name, master.secret, machine, url
        self._displace = displace
        self._load = load
        self._hear: Hear = lambda _kind, _key: None
        self._fact: AskFact = _knows_nothing
        self._missed: Callable[[], None] = lambda: None
        self._ends = Unavailable("the cloud is shutting down")
        self.master = MasterLink(master.where, self._registration, self, self._greet)
        self.cloud = EndpointCloud(self.master, self._places, Quotas(quota))
        self.sessions = EndpointSessions(self.master, self._places)
        self._background = Background()
        self._process = psutil.Process()

    def _registration(self) -> Registration:
        here = self._listener
        return Registration(
            endpoint=self._name,
            machine=self._machine,
            secret=self._secret,
            release=version("ppaas"),
            pid=os.getpid(),
            address=here.address,
            far_address=here.far_address,
            container_secret=here.secret,
            url=self._url,
        )

    def _greet(self) -> None:
        """Send the clients of this endpoint to a new master, and drop from caches what may have changed meanwhile."""
        self._missed()
        self.cloud.master_found()
        self.sessions.master_found()

    def connect_caches(self, hear: Hear, missed: Callable[[], None]) -> None:
        """Pass news of other processes to a function; call another one when news may have been missed."""
        self._hear, self._missed = hear, missed

    def answer_by(self, fact: AskFact) -> None:
        """Answer other processes that ask for facts about robots by a function."""
        self._fact = fact

    async def start(self) -> None:
        """Listen for containers."""
        await self._listener.start()
        self._background.run(repeat(self._forget_idle, PERIOD))

    async def run(self, orphaned: float, replaced: Replaced) -> None:
        """Keep the link to the master up; return once this endpoint is of no use any more.

        Parameters
        ----------
        orphaned : float
            Time without a master after which it is [s].
        replaced : callable
            Returns whether another master leads, which this endpoint does not reach; asked while its own is silent, or
            does not lead.

        Raises
        ------
        Conflict, NotPermitted
            The master refuses this endpoint.
        """
        running = asyncio.create_task(self.master.run())
        waiting = asyncio.create_task(self._until_orphaned(orphaned, replaced))
        try:
            done, _ = await asyncio.wait((running, waiting), return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            for task in (running, waiting):
                task.cancel()
            await asyncio.gather(running, waiting, return_exceptions=True)

    async def _until_orphaned(self, orphaned: float, replaced: Replaced) -> None:
        loop = asyncio.get_running_loop()
        until = loop.time() + START_PATIENCE
        while True:
            await asyncio.sleep(PERIOD)
            led = await self._report()
            if self.master.is_up:  # a master that is slow, or stopped, has not ended
                until = loop.time() + orphaned
            elif loop.time() >= until:
                self._ends = Unavailable("no master was reachable for a while: connect again")
                break
            if not led and await replaced():
                self._ends = Unavailable("another process leads this cloud now: connect again")
                break
        logger.warning("this endpoint ends: %s", self._ends)

    async def _report(self) -> bool:
        """Report the load of this process to the master; return whether it answers, and leads."""
        cpu = self._process.cpu_percent() / 100.0
        sockets, frames = self._load()
        state = EndpointState(sockets, frames, cpu, self._process.memory_info().rss)
        try:
            async with asyncio.timeout(SILENCE):
                return await self.master.call(MasterCalls.report, state)
        except (TimeoutError, Unavailable):
            return False

    async def _forget_idle(self) -> None:
        for key in self._places.idle():
            with contextlib.suppress(Unavailable):
                await self.master.call(MasterCalls.forget_place, key)
                if key in self._places.idle():  # else it was used meanwhile
                    self._places.close(key, Unavailable("nobody used the place at this endpoint"))

    async def close(self) -> None:
        """End all links; the clients are notified."""
        self._places.close_all(self._ends)
        await self._background.cancel()
        await self.sessions.close()
        await self._listener.close()

    # -- calls of the master -------------------------------------------------------------------------------------------

    async def place_closed(self, key: str, reason: Refusal) -> None:
        """Handle that a place was closed: its clients here are notified of the reason."""
        self._places.close(key, error_of(reason))

    async def hear(self, kind: NewsKind, key: str) -> None:
        """Drop a record from caches, as another process has changed it."""
        self._hear(kind, key)

    async def fact(self, kind: FactKind, user: str, robot: str) -> bytes | None:
        """Return what this endpoint knows of a robot, as JSON; None if it does not know it."""
        return await self._fact(kind, user, robot)

    async def displace(self, user: str, robot: str, session: str | None) -> None:
        """Displace the socket of a robot that connects at another endpoint."""
        await self._displace(user, robot, session)
