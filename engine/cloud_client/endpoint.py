"""Endpoint: connects the web application with the master and with the containers of its clients."""

import asyncio
import contextlib
import logging
import os
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path

import psutil

from engine.calls.interface import remote
from engine.cloud_client.cloud import EndpointCloud
from engine.cloud_client.link_listener import LinkListener, MachineAccess
from engine.cloud_client.master_link import MasterAccess, MasterLink, SilenceCause
from engine.cloud_client.sessions import EndpointPlaces, EndpointSessions
from engine.control.master_calls.interface import EndpointState, MasterCalls, Registration, RequestCounts
from engine.control.news import AskFact, FactKind, Hear, NewsKind
from engine.master.quotas import Quota, Quotas
from engine.processes.background import Background, repeat
from engine.processes.heartbeats import BEAT_PERIOD, BeatFile
from engine.protocols.address import endpoint_socket
from engine.protocols.versions import OWN
from ppaas import __version__
from ppaas.errors import PPaaSError, Unavailable

logger = logging.getLogger(__name__)

PERIOD = 1.0
"""Interval of reports to the master [s]."""

START_PATIENCE = 60.0
"""Time within which a new endpoint reaches the master [s]."""

SILENCE = 1.0
"""Time within which the master answers a report [s]."""

GIVE_UP = 4.0
"""Time without an answer after which the link to a master of another host is closed [s]: TCP may not notice that the
network is down. The master closes it after as long without a report."""

SUCCESSION = 3.0
"""Time for which an endpoint of a master that was replaced serves on [s]: its clients would find no other place to go
before the next master has registered machines and endpoints. Their containers go on meanwhile."""

Displace = Callable[[str, str, str | None], Awaitable[None]]
"""Displaces the socket of a user's robot, if it is dead or of the named session."""

Load = Callable[[], tuple[int, float, RequestCounts]]
"""Returns the number of sockets, and the frames of clients since the last call [1/s]."""


@dataclass(frozen=True, slots=True)
class Here:
    """Endpoint as the master and containers know it.

    Parameters
    ----------
    name : str
        Name of the endpoint, unique in the cloud.
    machine : str
        Machine on which it runs.
    run_dir : Path
        Folder for the socket that containers dial.
    url : str
        Address at which it serves clients.
    advertised : str
        Address sent to clients whose container is on this machine; empty for none.
    machines : MachineAccess, optional
        Access for containers of other hosts; None for none.
    """

    name: str
    machine: str
    run_dir: Path
    url: str
    advertised: str = ""
    machines: MachineAccess | None = None


async def _knows_nothing(_kind: FactKind, _user: str, _robot: str) -> bytes | None:
    return None


class Endpoint:
    """The engine's part of an endpoint process.

    Parameters
    ----------
    here : Here
        Its name and addresses.
    master : MasterAccess
        Access to the master.
    quota : Quota
        Quota of users without own limits.
    displace : callable
        Displaces the socket of a robot that connects at another endpoint.
    load : callable
        Returns the number of sockets, and the frames of clients since the last call [1/s].

    Attributes
    ----------
    master : MasterLink
    cloud : EndpointCloud
    sessions : EndpointSessions
    """

    def __init__(self, here: Here, master: MasterAccess, quota: Quota, *, displace: Displace, load: Load) -> None:
        self._places = EndpointPlaces()
        socket = endpoint_socket(here.run_dir, here.name)
        self._listener = LinkListener(here.machine, socket, self._places.link, here.machines)
        self._here, self._access = here, master
        self._beat = BeatFile(here.run_dir, here.name)
        self._displace = displace
        self._load = load
        self._hear: Hear = lambda _kind, _key: None
        self._fact: AskFact = _knows_nothing
        self._missed: Callable[[], None] = lambda: None
        self._ends = Unavailable("the cloud is shutting down")
        self.master = MasterLink(master, self._registration, self, self._greet)
        self._calls = remote(MasterCalls, self.master)
        self.cloud = EndpointCloud(self.master, self._places, Quotas(quota))
        self.sessions = EndpointSessions(self.master, self._places)
        self._background = Background()
        self._process = psutil.Process()

    def _registration(self) -> Registration:
        return Registration(
            endpoint=self._here.name,
            secret=self._access.secret,
            release=__version__,
            pid=os.getpid(),
            at=self._listener.address,
            container_secret=self._listener.secret,
            url=self._here.url,
            advertised=self._here.advertised,
            protocols=OWN,
        )

    def _greet(self) -> None:
        """Send the clients of this endpoint to a new master, and drop from caches what may have changed meanwhile."""
        self._missed()
        self.cloud.master_found()
        self.sessions.master_found()
        self._background.run(self._learn_state())

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
        self._background.run(repeat(self._show_life, BEAT_PERIOD))

    async def _show_life(self) -> None:
        """Show the keeper of this process that it is not frozen."""
        self._beat.beat()

    async def run(self, orphaned: float) -> None:
        """Keep the link to the master up; return once this endpoint is of no use any more.

        Parameters
        ----------
        orphaned : float
            Time without a master after which it is [s].

        Raises
        ------
        Conflict, NotPermitted
            The master refuses this endpoint.
        """
        running = asyncio.create_task(self.master.run())
        waiting = asyncio.create_task(self._until_orphaned(orphaned))
        try:
            done, _ = await asyncio.wait((running, waiting), return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            for task in (running, waiting):
                task.cancel()
            await asyncio.gather(running, waiting, return_exceptions=True)

    async def _until_orphaned(self, orphaned: float) -> None:
        loop = asyncio.get_running_loop()
        until = loop.time() + START_PATIENCE
        while True:
            await asyncio.sleep(PERIOD)
            led = await self._report()
            # TCP may not notice that the network is down.
            if self._access.is_far and self.master.is_up and self.master.silence > GIVE_UP:
                logger.warning("the master is silent: it or the network is down, and this endpoint dials again")
                self.master.hang_up()
            if self.master.is_up:  # a master that is slow, or stopped, has not ended
                until = loop.time() + orphaned
            elif loop.time() >= until:
                self._ends = Unavailable("no master was reachable for a while: connect again")
                break
            if not led and await self._is_replaced():
                self._ends = Unavailable("another process leads this cloud now: connect again")
                self.cloud.is_replaced = True  # proxies send no new connections
                await asyncio.sleep(SUCCESSION)
                break
        logger.warning("this endpoint ends: %s", self._ends)

    async def _is_replaced(self) -> bool:
        """Return whether another master leads that is not reached from here; go to one that is."""
        silence = await self._access.silence()
        if silence is SilenceCause.MOVED:
            logger.warning("another master leads: this endpoint leaves the one that is silent")
            self.master.hang_up()
        return silence is SilenceCause.REPLACED

    async def _report(self) -> bool:
        """Report the load of this process to the master; return whether it answers, and leads."""
        cpu = self._process.cpu_percent() / 100.0
        sockets, frames, requests = self._load()
        state = EndpointState(sockets, frames, cpu, self._process.memory_info().rss, requests)
        try:
            async with asyncio.timeout(SILENCE):
                master = await self._calls.report(state)
        except (TimeoutError, Unavailable):
            return False
        self.cloud.start = master.start
        return master.leads

    async def _learn_state(self) -> None:
        await self._report()

    async def _forget_idle(self) -> None:
        for key in self._places.idle():
            with contextlib.suppress(Unavailable):
                await self._calls.forget_place(key)
                if key in self._places.idle():  # else it was used meanwhile
                    self._places.close(key, Unavailable("nobody used the place at this endpoint"))

    async def close(self) -> None:
        """End all links; the clients are notified."""
        self._places.close_all(self._ends)
        await self._background.cancel()
        await self.sessions.close()
        await self._listener.close()

    # -- calls of the master -------------------------------------------------------------------------------------------

    async def place_closed(self, key: str, reason: PPaaSError) -> None:
        """Handle that a place was closed: its clients here are notified of the reason."""
        self._places.close(key, reason)

    async def hear(self, kind: NewsKind, key: str) -> None:
        """Drop a record from caches, as another process has changed it."""
        self._hear(kind, key)

    async def fact(self, kind: FactKind, user: str, robot: str) -> bytes | None:
        """Return what this endpoint knows of a robot, as JSON; None if it does not know it."""
        return await self._fact(kind, user, robot)

    async def displace(self, user: str, robot: str, session: str | None) -> None:
        """Displace the socket of a robot that connects at another endpoint."""
        await self._displace(user, robot, session)
