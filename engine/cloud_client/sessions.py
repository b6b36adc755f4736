"""Places that an endpoint reaches by links that containers dial, and their clients, which the master counts."""

import asyncio
import logging
from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

from engine.calls.interface import remote
from engine.cloud_client.master_link import MasterLink, undone_if_cancelled
from engine.control.master_calls.interface import ClientJoin, JoinedPlace, MasterCalls
from engine.links.place_link import PlaceLink
from engine.processes.background import Background
from ppaas.clock import Clock, monotonic
from ppaas.errors import Conflict, PPaaSError, Unavailable

logger = logging.getLogger(__name__)


# -- places ------------------------------------------------------------------------------------------------------------

IDLE = 120.0
"""Time after its last use for which a place without clients is reached [s]."""


@dataclass(slots=True)
class _Reached:
    link: PlaceLink
    used: float


class EndpointPlaces:
    """Links of the places that clients of this endpoint use.

    Parameters
    ----------
    clock : callable
        Returns monotonic seconds.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._reached: dict[str, _Reached] = {}

    def link(self, key: str) -> PlaceLink:
        """Return the link of a place by name; a container may dial before the master has answered."""
        reached = self._reached.get(key)
        if reached is None:
            reached = self._reached[key] = _Reached(PlaceLink(key), self._clock())
        reached.used = self._clock()
        return reached.link

    def running(self, key: str) -> PlaceLink | None:
        """Return the link of a place whose container is connected with this endpoint; None if there is none."""
        reached = self._reached.get(key)
        if reached is None or reached.link.container is None:
            return None
        reached.used = self._clock()
        return reached.link

    def joined(self, place: JoinedPlace) -> PlaceLink:
        """Return the link of a place that the master has opened."""
        link = self.link(place.key)
        link.base_frame, link.nearer = place.base_frame, place.nearer
        return link

    def close(self, key: str, reason: PPaaSError) -> None:
        """Close a place, and notify its clients."""
        reached = self._reached.pop(key, None)
        if reached is not None:
            reached.link.close(reason)

    def idle(self) -> list[str]:
        """Return the places without clients that were not used for a while."""
        latest = self._clock() - IDLE
        return [key for key, one in self._reached.items() if not one.link.has_clients and one.used < latest]

    def close_all(self, reason: PPaaSError) -> None:
        """Close all places, and notify their clients."""
        for key in tuple(self._reached):
            self.close(key, reason)


# -- clients -----------------------------------------------------------------------------------------------------------

RETRY = 1.0
"""Time after which a client that cannot join the place again tries once more [s]."""


class _Kind(NamedTuple):
    key: str
    as_robot: bool


class EndpointSessions:
    """Joins the places of robots for the clients of this endpoint; implements ``RobotPlaces``.

    Parameters
    ----------
    master : MasterLink
    places : EndpointPlaces
    """

    def __init__(self, master: MasterLink, places: EndpointPlaces) -> None:
        self._master = master
        self._calls = remote(MasterCalls, master)
        self._places = places
        self._clients: Counter[_Kind] = Counter()
        self._told: Counter[_Kind] = Counter()
        """Number of clients that the master knows of."""
        self._robots: dict[str, tuple[str, str]] = {}
        """User and id of the robots of places that have clients here."""
        self._masters = 0
        self._background = Background()

    async def join(
        self,
        user: str,
        robot: str,
        *,
        as_robot: bool,
        hold: bool = True,
        queue: bool = False,
        session: str | None = None,
    ) -> PlaceLink:
        """Add a client to the place of a robot and return the place; see ``RobotSessions.join``.

        The master goes on if the client gives up meanwhile; it is then told that the client has left.
        """

        def leave(place: PlaceLink) -> None:
            if hold:
                self.leave(place.key, as_robot=as_robot)

        return await undone_if_cancelled(self._join(ClientJoin(user, robot, as_robot, hold, queue, session)), leave)

    async def _join(self, join: ClientJoin) -> PlaceLink:
        joined = await self._calls.join(join)
        if join.hold:
            kind = _Kind(joined.key, join.as_robot)
            self._robots[joined.key] = join.user, join.robot
            self._clients[kind] += 1
            self._told[kind] += 1
        return self._places.joined(joined)

    def leave(self, key: str, *, as_robot: bool) -> None:
        """Remove a client from a place."""
        kind = _Kind(key, as_robot)
        if self._clients[kind] > 0:
            self._clients[kind] -= 1
            self._settle(kind)

    def _settle(self, kind: _Kind) -> None:
        while self._told[kind] > self._clients[kind]:
            self._told[kind] -= 1
            self._master.tell(MasterCalls.leave, kind.key, kind.as_robot)
        for counts in (self._told, self._clients):
            if not counts[kind]:
                del counts[kind]
        if not any(_Kind(kind.key, as_robot) in self._clients for as_robot in (True, False)):
            self._robots.pop(kind.key, None)

    async def position(self, place: PlaceLink) -> int | None:
        """Return the position of a place in the queue, from 1; None if it is not queued."""
        return await self._calls.position(place.key)

    async def let_go(self, place: PlaceLink, reason: PPaaSError) -> None:
        """Close a place although clients are connected, and notify them of the reason."""
        await self._calls.let_go(place.key, reason)

    def master_found(self) -> None:
        """Join the places of all clients again, at a new master; clients that it refuses are notified.

        A link that is lost meanwhile ends this: all clients join at the next master.
        """
        self._told.clear()
        self._masters += 1
        for kind in tuple(self._clients):
            self._background.run(self._join_again(kind, self._masters))

    async def _join_again(self, kind: _Kind, master: int) -> None:
        user, robot = self._robots[kind.key]
        join = ClientJoin(user, robot, kind.as_robot, hold=True, queue=True)
        try:
            while self._has_master(master) and self._told[kind] < self._clients[kind]:
                await self._try_again(kind, join)
        except Conflict as error:
            self._refuse(kind, Unavailable(f"another endpoint has the robot now: {error}"))
        except PPaaSError as error:
            self._refuse(kind, error)
        finally:
            self._settle(kind)

    def _has_master(self, number: int) -> bool:
        """Return whether the link to a master, by its number, is still up; a call would wait for the next one."""
        return self._masters == number and self._master.is_up

    def _refuse(self, kind: _Kind, error: PPaaSError) -> None:
        logger.warning("the master refuses the clients of %s: %s", kind.key, error)
        self._places.close(kind.key, error)

    async def _try_again(self, kind: _Kind, join: ClientJoin) -> None:
        """Join once; if that is not possible now, the clients drive on with the container they have."""
        try:
            joined = await self._calls.join(join)
        except Unavailable as error:
            logger.info("a client cannot join %s again yet: %s", kind.key, error)
            await asyncio.sleep(RETRY)
        else:
            self._told[kind] += 1
            self._places.joined(joined)

    async def close(self) -> None:
        """End what runs in the background."""
        await self._background.cancel()
