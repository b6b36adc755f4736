"""Stops of robots: who is stopped, until somebody releases them; orders to the clones, and their confirmations."""

import asyncio
import contextlib
import logging
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Protocol

import msgspec

from engine.links.place_link import PlaceLink
from engine.master.places import PlaceRequest
from engine.processes.background import Background
from engine.protocols.robot_link import SetStops
from engine.specs.robot_stops import stops_of_robot, store_stops, stored_stops
from ppaas.clock import Clock, epoch
from ppaas.errors import NotPermitted, PPaaSError, Unavailable
from ppaas.messages.health.stops import RobotStop
from storage.ports import CloneStore

logger = logging.getLogger(__name__)

# -- the stops of one user ---------------------------------------------------------------------------------------------


class StopBook:
    """Stops of the robots of one user, of each scope and name one: the first stays until it is released.

    Parameters
    ----------
    stops : iterable of RobotStop
    """

    def __init__(self, stops: Iterable[RobotStop] = ()) -> None:
        self._stops = {stop.key: stop for stop in stops}

    @property
    def stops(self) -> tuple[RobotStop, ...]:
        """All stops, oldest first."""
        return tuple(self._stops.values())

    def add(self, stop: RobotStop) -> RobotStop:
        """Add a stop, and return the one in force: an earlier one of the same scope and name stays."""
        return self._stops.setdefault(stop.key, stop)

    def release(self, scope: str, name: str, by: str, *, of_others: bool) -> RobotStop | None:
        """Release a stop, and return it; None if there is none.

        Raises
        ------
        NotPermitted
            Another user made it, and stops of others may not be released.
        """
        stop = self._stops.get((scope, name))
        if stop is None:
            return None
        if stop.by != by and not of_others:
            raise NotPermitted(
                f"the robot was stopped by {stop.by!r}: they may release it, or who may administer the robot"
            )
        return self._stops.pop(stop.key)

    def of(self, robot: str, map_id: str) -> tuple[RobotStop, ...]:
        """Return the stops that apply to a robot on a map."""
        return stops_of_robot(self.stops, robot, map_id)


# -- all robots --------------------------------------------------------------------------------------------------------

CONFIRMATION = 1.0
"""Time to wait until the clones confirm a stop [s]."""


class StopOrder(msgspec.Struct, frozen=True):
    """Order to stop robots of a user.

    Parameters
    ----------
    user : str
        Owner of the robots.
    stop : RobotStop
    """

    user: str
    stop: RobotStop


class StopReport(msgspec.Struct, frozen=True):
    """What became of an order.

    Parameters
    ----------
    user : str
        Owner of the robots.
    stop : RobotStop
        The stop in force, which may be an earlier one.
    standing : tuple of str
        Robots whose clones send nothing but zero now, and those that run Move Base themselves and have confirmed it.
    unconfirmed : tuple of str
        Robots with a container of which that is not known within `CONFIRMATION`.
    """

    user: str
    stop: RobotStop
    standing: tuple[str, ...] = ()
    unconfirmed: tuple[str, ...] = ()


class StopCalls(Protocol):
    """Stops of robots of all users."""

    async def stop(self, orders: list[StopOrder]) -> list[StopReport]:
        """Stop robots, store that, and report which clones have confirmed it.

        Raises
        ------
        Unavailable
            The robots are stopped, but that is not stored.
        """
        ...

    async def release(self, user: str, scope: str, name: str, by: str, of_others: bool) -> RobotStop | None:
        """Release a stop of the robots of a user, and return it; None if there is none, as after an earlier release.

        Parameters
        ----------
        user, scope, name : str
            Owner of the robots, scope and name of the stop.
        by : str
            User who releases it.
        of_others : bool
            Whether that may be a stop that another user made.

        Raises
        ------
        NotPermitted
            Another user made it, and ``of_others`` is false.
        Unavailable
            It could not be stored: the robots stay stopped.
        """
        ...


class StoppedPlaces(Protocol):
    """Open places, as a driver of the master knows them."""

    def place(self, key: str) -> PlaceLink | None:
        """Return the link of an open place, or None."""
        ...

    def request_of(self, key: str) -> PlaceRequest | None:
        """Return the request of an open or queued place, or None."""
        ...


class RobotStops:
    """Stops and releases robots; implements ``StopCalls``.

    What is stored is what holds. A clone gets its stops with its container, and each change at once. Whenever one
    reports other stops than it should have, it gets them again: after a restart of the master, a lost link, a change of
    the container.

    Parameters
    ----------
    places : StoppedPlaces
    store : CloneStore
        Keeps the stops.
    clock : callable
        Returns the time [s since the epoch].

    Attributes
    ----------
    requested : callable
        Called with the owner of a robot that a client has stopped by its socket, and the stop.
    stored : callable
        Called with each user whose stops were stored, so that caches drop them.
    """

    def __init__(self, places: StoppedPlaces, store: CloneStore, clock: Clock = epoch) -> None:
        self.requested: Callable[[str, RobotStop], None] = lambda _user, _stop: None
        self.stored: Callable[[str], None] = lambda _user: None
        self._places = places
        self._store = store
        self._clock = clock
        self._books: dict[str, StopBook] = {}
        self._owners: dict[str, str] = {}
        self._writing = asyncio.Lock()
        self._background = Background()
        self._heard = asyncio.Event()

    async def close(self) -> None:
        """End what goes on in the background."""
        await self._background.cancel()

    # -- calls ---------------------------------------------------------------------------------------------------------

    async def stop(self, orders: list[StopOrder]) -> list[StopReport]:
        """Stop robots; see `StopCalls.stop`."""
        books = {user: await self._book(user) for user in dict.fromkeys(order.user for order in orders)}
        kept = [StopReport(order.user, books[order.user].add(order.stop)) for order in orders]
        for user in books:
            self._send_all(user)
        try:
            await asyncio.gather(*map(self._keep, books), self._confirmed(kept))
        except PPaaSError as error:
            raise Unavailable(f"the robots are stopped, but that could not be stored: {error}; try again") from error
        return [self._report(one) for one in kept]

    async def release(self, user: str, scope: str, name: str, by: str, of_others: bool) -> RobotStop | None:
        """Release a stop; see `StopCalls.release`."""
        book = await self._book(user)
        stop = book.release(scope, name, by, of_others=of_others)
        if stop is None:
            return None
        try:
            await self._keep(user)
        except PPaaSError as error:
            book.add(stop)
            raise Unavailable(f"the robots stay stopped, because their release could not be stored: {error}") from error
        finally:
            self._send_all(user)
        return stop

    # -- places --------------------------------------------------------------------------------------------------------

    def place_opened(self, key: str) -> None:
        """Follow what the clones of a robot report, whose place was opened or adopted."""
        place, request = self._places.place(key), self._places.request_of(key)
        if place is not None and request is not None and request.robot is not None:
            self._owners[key] = request.user
            place.stops_reported = partial(self._reported, key)

    def _reported(self, key: str) -> None:
        self._heard.set()
        self._heard = asyncio.Event()
        self._background.run(self._settle(key))

    async def _settle(self, key: str) -> None:
        """Give a clone the stops that it should have, if it reports others; keep what its clients have requested."""
        user, place = self._owners.get(key, ""), self._places.place(key)
        if place is None or place.stops is None:
            return
        try:
            book = await self._book(user)
            requested = [stop for stop in place.stops.requested if book.add(stop) is stop]
            self._send(key, book)
            if requested:
                await self._keep(user)
        except PPaaSError as error:
            logger.error("the stops of %s cannot be compared with what is stored: %s", key, error)
            return
        for stop in requested:
            logger.warning("%s is stopped by a client of its socket", key)
            self.requested(user, stop)

    def _send_all(self, user: str) -> None:
        book = self._books[user]
        for key in [key for key, owner in self._owners.items() if owner == user]:
            self._send(key, book)

    def _send(self, key: str, book: StopBook) -> None:
        place, request = self._places.place(key), self._places.request_of(key)
        if place is None or request is None or request.robot is None:
            self._owners.pop(key, None)
            return
        stops = book.of(request.robot.id, request.map.id)
        known = place.stops
        if known is not None and (known.stops != stops or known.requested):
            place.send(SetStops(stops))

    # -- confirmations -------------------------------------------------------------------------------------------------

    async def _confirmed(self, reports: Sequence[StopReport]) -> None:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(CONFIRMATION):
                while any(self._report(one).unconfirmed for one in reports):
                    await self._heard.wait()

    def _report(self, report: StopReport) -> StopReport:
        standing, unconfirmed = list[str](), list[str]()
        for key, owner in self._owners.items():
            place, request = self._places.place(key), self._places.request_of(key)
            if owner != report.user or place is None or request is None or request.robot is None:
                continue
            if place.container is None or not report.stop.applies_to(request.robot.id, request.map.id):
                continue
            known = place.stops
            confirmed = known is not None and report.stop in known.stops and not known.unheard
            (standing if confirmed else unconfirmed).append(request.robot.id)
        return msgspec.structs.replace(report, standing=tuple(standing), unconfirmed=tuple(unconfirmed))

    # -- store ---------------------------------------------------------------------------------------------------------

    async def _book(self, user: str) -> StopBook:
        if user not in self._books:
            stops = await asyncio.to_thread(stored_stops, self._store, user)
            self._books.setdefault(user, StopBook(stops))
        return self._books[user]

    async def _keep(self, user: str) -> None:
        """Store the stops of a user; of two writes, the later one has all that is known then."""
        async with self._writing:
            await asyncio.to_thread(store_stops, self._store, user, self._books[user].stops, self._clock())
        self.stored(user)
