"""Endpoint as the master serves it: its clients, the places that it reaches, and its calls."""

import asyncio
import logging
import re
from collections import Counter
from collections.abc import Callable
from functools import partial

from engine.calls.caller import Caller
from engine.calls.interface import method_of
from engine.control.master_calls.cloud import Cloud
from engine.control.master_calls.interface import (
    ClientJoin,
    EndpointCalls,
    EndpointState,
    JoinedPlace,
    MasterCalls,
    Registration,
    ReportAnswer,
)
from engine.control.news import FactKind, NewsKind
from engine.control.robot_sessions import RobotSessions
from engine.links.place_link import PlaceLink
from engine.master.places import robot_key
from engine.protocols.handshakes import is_same, place_secret
from engine.protocols.robot_link import DialEndpoint
from engine.protocols.versions import agree
from engine.specs.containers import MapVersion
from ppaas.errors import NotPermitted, PPaaSError, Unavailable

logger = logging.getLogger(__name__)

NUMBERED = re.compile(r"-\d{1,4}")
"""End of the name of an endpoint, after that of its machine."""

EPOCH_SHIFT = 32
"""Bits of the number of a container within its generation; the epoch of the master is above them."""


class ServedEndpoint:
    """One endpoint; implements ``MasterCalls``.

    Parameters
    ----------
    cloud : Cloud
    sessions : RobotSessions
    secret : str
        Secret of the cloud's own processes.
    machine : str, optional
        Machine that its certificate names; None for an endpoint of this host.

    Attributes
    ----------
    registered : callable
        Called when the endpoint has registered.
    """

    def __init__(self, cloud: Cloud, sessions: RobotSessions, secret: str, machine: str | None = None) -> None:
        self._cloud = cloud
        self._driver = cloud.driver
        self._sessions = sessions
        self._neighbours = cloud.neighbours
        self._secret = secret
        self.machine = machine
        self.registration: Registration | None = None
        self.state: EndpointState | None = None
        self.beats = 0
        self.heard = self._neighbours.clock()
        self.caller: Caller | None = None
        self.registered: Callable[[], None] = lambda: None
        self._joined: Counter[tuple[str, bool]] = Counter()
        self._reached: dict[str, tuple[PlaceLink, int]] = {}

    @property
    def name(self) -> str:
        """Name of the endpoint; empty before it has registered."""
        return "" if self.registration is None else self.registration.endpoint

    def may_call(self, method: str) -> bool:
        """Return whether the endpoint may call a method: any, once it has registered."""
        return self.registration is not None or method == method_of(MasterCalls.register).name

    async def register(self, registration: Registration) -> None:
        """Register the endpoint.

        Raises
        ------
        Conflict
            It speaks no protocol of this master.
        NotPermitted
            It is none of this cloud, its name is not one of its machine, or its machine was removed.
        """
        self._check_origin(registration)
        agree(f"endpoint {registration.endpoint!r}", registration.release, registration.protocols)
        self._neighbours.hang_up(registration.endpoint)  # of an earlier process, if the network was down
        self.registration = registration
        self.registered()
        self.heard = self._neighbours.clock()
        self._neighbours.add(self)
        self._cloud.news.listen(self._hear)
        self._cloud.fact_sources.add(self._fact)
        logger.info("endpoint %s serves, as process %d", registration.endpoint, registration.pid)

    def _check_origin(self, registration: Registration) -> None:
        own = registration.at.machine
        if self.machine is None:
            if not is_same(self._secret, registration.secret):
                raise NotPermitted("an endpoint without the secret of this cloud tried to register")
        elif own != self.machine:
            raise NotPermitted(
                f"an endpoint of machine {self.machine!r} may not register as one of {own[:64]!r}: its certificate "
                f"names {self.machine!r}"
            )
        elif self._driver.administration.is_removed(own):
            raise NotPermitted(f"machine {own!r} was removed: an administrator must admit it first")
        if not NUMBERED.fullmatch(registration.endpoint.removeprefix(own)):
            raise NotPermitted(f"{registration.endpoint[:80]!r} is no name of an endpoint of machine {own!r}")

    def hang_up(self) -> None:
        """Close the link."""
        if self.caller is not None:
            self.caller.hang_up()

    async def report(self, state: EndpointState) -> ReportAnswer:
        """Note the load of the endpoint; return the state of this master."""
        self.state = state
        self.beats += 1
        self.heard = self._neighbours.clock()
        return ReportAnswer(self._driver.mandate.leads(), self._cloud.start)

    def gone(self) -> None:
        """Remove all clients of the endpoint, which has ended or is not reachable."""
        self._neighbours.remove(self)
        self._cloud.news.leave(self._hear)
        self._cloud.fact_sources.remove(self._fact)
        for (key, as_robot), count in self._joined.items():
            for _ in range(count):
                self._sessions.leave(key, as_robot=as_robot)
        for key in tuple(self._reached):
            self._forget(key)
        self._joined.clear()

    # -- places --------------------------------------------------------------------------------------------------------

    async def join(self, join: ClientJoin) -> JoinedPlace:
        """Add a client to the place of a robot, and let its containers dial the endpoint."""
        if join.as_robot:
            # First, so that a dead socket of the robot does not refuse this one.
            await self._neighbours.displace(self, join)
        place = await self._sessions.join(
            join.user, join.robot, as_robot=join.as_robot, hold=join.hold, queue=join.queue
        )
        if join.hold:
            self._joined[place.key, join.as_robot] += 1
        return self._reach(place)

    async def leave(self, key: str, as_robot: bool) -> None:
        """Remove a client from a place."""
        if self._joined[key, as_robot] > 0:
            self._joined[key, as_robot] -= 1
            self._sessions.leave(key, as_robot=as_robot)

    def has_robot(self, key: str) -> bool:
        """Return whether the endpoint has the socket of the robot of a place."""
        return self._joined[key, True] > 0

    async def let_go(self, key: str, reason: PPaaSError) -> None:
        """Close a place although clients are connected, and notify them of the reason."""
        reached = self._reached.get(key)
        if reached is not None:
            await self._sessions.let_go(reached[0], reason)

    async def position(self, key: str) -> int | None:
        """Return the position of a place in the queue, from 1; None if it is not queued."""
        reached = self._reached.get(key)
        return None if reached is None else await self._sessions.position(reached[0])

    async def visit(self, user: str, robot: str) -> JoinedPlace:
        """Let the containers of a robot's place dial the endpoint, which calls services there."""
        place = self._driver.place(robot_key(user, robot))
        if place is None:
            raise Unavailable(f"robot {robot!r} has no container now: its nodes run while it is connected")
        return self._reach(place)

    async def open_planning(self, user: str, version: MapVersion, labels: dict[str, str], queue: bool) -> JoinedPlace:
        """Open the place of a planning container, or use it."""
        place = self._cloud.planning_places.use(user, version, labels, queue=queue)
        return self._reach(place)

    async def forget_place(self, key: str) -> None:
        """Let the containers of a place leave the endpoint, unless a client of it is there."""
        if not any(self._joined[key, as_robot] > 0 for as_robot in (True, False)):
            self._forget(key)

    # -- the cloud -----------------------------------------------------------------------------------------------------

    async def announce(self, kind: NewsKind, key: str) -> None:
        """Tell the other processes of the cloud that this endpoint has changed a record."""
        self._cloud.news.tell(kind, key, source=self._hear)

    def _hear(self, kind: NewsKind, key: str) -> None:
        if self.caller is not None:
            self.caller.tell(EndpointCalls.hear, kind, key)

    async def facts(self, kind: FactKind, user: str, robot: str) -> list[bytes]:
        """Return what the other processes of the cloud know of a robot, as JSON."""
        return await self._cloud.fact_sources.ask(kind, user, robot, but=self._fact)

    async def _fact(self, kind: FactKind, user: str, robot: str) -> bytes | None:
        return None if self.caller is None else await self.caller.call(EndpointCalls.fact, kind, user, robot)

    # -- ends ----------------------------------------------------------------------------------------------------------

    def _reach(self, place: PlaceLink) -> JoinedPlace:
        """Let the containers of a place dial the endpoint, and tell the endpoint when the place is closed."""
        known = self._reached.get(place.key)
        if known is None or known[0] is not place:
            if known is not None:
                self._forget(place.key)
            self._reached[place.key] = place, place.join(_Closing(self, place.key))
        here = self.registration
        assert here is not None
        place.add_endpoint(here.endpoint, partial(self._dial_order, here, place.key))
        nearer = self._neighbours.nearer(here, self._driver.machine_of_place(place.key))
        return JoinedPlace(place.key, place.base_frame, self._driver.position(place.key), nearer)

    def _dial_order(self, here: Registration, place: str, container: int) -> DialEndpoint:
        # A container of a later master outranks all of an earlier one.
        generation = self._driver.mandate.epoch << EPOCH_SHIFT | container
        secret = place_secret(here.container_secret, place, generation)
        return DialEndpoint(here.endpoint, here.at, place, generation, secret)

    def _forget(self, key: str) -> None:
        reached = self._reached.pop(key, None)
        if reached is not None:
            place, client = reached
            place.leave(client)
            place.drop_endpoint(self.name)

    def place_closed(self, key: str, reason: PPaaSError) -> None:
        """Tell the endpoint that a place was closed."""
        self._reached.pop(key, None)
        if self.caller is not None:
            self.caller.tell(EndpointCalls.place_closed, key, reason)

    async def displace(self, user: str, robot: str, session: str | None, timeout: float) -> None:
        """Let the endpoint displace the socket of a robot, if it is dead or of the same session."""
        if self.caller is None:
            return
        try:
            async with asyncio.timeout(timeout):
                await self.caller.call(EndpointCalls.displace, user, robot, session)
        except TimeoutError:
            logger.warning("endpoint %s did not answer for the socket of robot %r in %g s", self.name, robot, timeout)


class _Closing:
    """Client of a place that waits for its end only."""

    def __init__(self, endpoint: ServedEndpoint, key: str) -> None:
        self._endpoint = endpoint
        self._key = key

    def published(self, topic: str, payload: bytes) -> None:
        """Ignore a message: this client subscribes to none."""

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        """Ignore a refusal: this client sends nothing."""

    def acknowledged(self, sequence: int) -> None:
        """Ignore that messages are in a checkpoint."""

    def closed(self, reason: PPaaSError) -> None:
        """Tell the endpoint."""
        self._endpoint.place_closed(self._key, reason)
