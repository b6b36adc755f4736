"""The sessions of all clients: who sits at which place, and who is away and may come back.

A session that has a name outlives its sockets. What a client hears, what waits for it and what it asked for is kept
for some time after its socket is gone, and handed to the next socket that names the session. One that comes while the
old socket still seems to stand takes over: the client knows better than we do whether that is dead.
"""

import asyncio
import logging
import secrets
from collections.abc import Iterable
from functools import partial
from typing import NamedTuple

from endpoints.http.websocket_protocol import Probe
from endpoints.rosbridge.connect_request import Visit
from endpoints.rosbridge.roles import Role
from endpoints.rosbridge.session import ClientSession
from engine.processes.background import Background
from engine.service.links.place_link import PlaceLink
from engine.service.plan_rate import PlanRate
from engine.service.robot_sessions import LINGER, RobotSessions
from ppaas.errors import Conflict, PPaaSError, Unavailable
from ppaas.wire import rosbridge
from ppaas.wire.resumption import ID_HEADER, NEW, RESUMED, STATE_HEADER, TAKEN_HEADER

logger = logging.getLogger(__name__)

READY_TIMEOUT = 15.0
PROBE_TIMEOUT = 2.0
"""Seconds that the socket of a robot may be silent when another comes for the same robot; then it is dead."""

POSITION_PERIOD = 0.5
"""Seconds between two looks at how far a robot has come in the queue."""

MAX_AWAY = 64
"""Sessions of one user that are kept without a socket; of more the one that is away longest is ended first."""


class SessionKey(NamedTuple):
    """Whose session it is."""

    user: str
    robot: str
    role: Role
    name: str


class Kept:
    """A session and what is known of it here; its ``taken`` counts the frames that were taken from the client."""

    def __init__(self, session: ClientSession, place: PlaceLink, key: SessionKey | None) -> None:
        self.id = secrets.token_hex(8)
        self.session = session
        self.place = place
        self.key = key
        self.taken = 0
        self.ended = False
        self.seat: Seat | None = None
        self.expiry: asyncio.TimerHandle | None = None


class Seat:
    """One socket's hold of a session.

    Attributes
    ----------
    gone : Future
        Done once the session was given to another socket; its result is what this one is told.
    """

    def __init__(self, kept: Kept, visit: Visit, user: str, probe: Probe, *, resumed: bool) -> None:
        self.kept = kept
        self.session = kept.session
        self.visit = visit
        self.user = user
        self.resumed = resumed
        self.gone: asyncio.Future[PPaaSError] = asyncio.get_running_loop().create_future()
        self._probe = probe
        self._left = asyncio.Event()

    @property
    def headers(self) -> list[tuple[bytes, bytes]]:
        """What the handshake tells a client that named its session."""
        if self.visit.session is None:
            return []
        told = {
            STATE_HEADER: RESUMED if self.resumed else NEW,
            ID_HEADER: self.kept.id,
            TAKEN_HEADER: str(self.kept.taken),
        }
        return [(name.encode(), value.encode()) for name, value in told.items()]

    async def answers(self) -> bool:
        """Tell whether the client is still there: it answers a ping, or says something meanwhile."""
        taken = self.kept.taken
        return await self._probe(PROBE_TIMEOUT) or self.kept.taken != taken

    async def evict(self, why: PPaaSError) -> None:
        """Take the session from this socket, and wait until it touches it no more."""
        if not self.gone.done():
            self.gone.set_result(why)
        await self._left.wait()

    @property
    def has_left(self) -> bool:
        """The socket is gone, or the place is no more."""
        return self._left.is_set() or self.session.over.done()

    def leave(self) -> None:
        """Touch the session no more."""
        self._left.set()
        if self.kept.seat is self:
            self.kept.seat = None


class ClientSessions:
    """Gives each socket its session.

    Parameters
    ----------
    robots : RobotSessions
        Opens the places.
    plan_rate : PlanRate
        Counts the paths that clients ask for.
    linger : float
        Seconds that a session is kept without a socket.
    """

    def __init__(self, robots: RobotSessions, plan_rate: PlanRate, linger: float = LINGER) -> None:
        self._robots = robots
        self._plan_rate = plan_rate
        self._linger = linger
        self._kept: dict[SessionKey, Kept] = {}
        self._seats: set[Seat] = set()
        self._telling = Background()

    def seats(self) -> Iterable[Seat]:
        """Return all who are connected now."""
        return tuple(self._seats)

    @property
    def away(self) -> int:
        """How many sessions are kept without a socket."""
        return sum(kept.seat is None for kept in self._kept.values())

    def close(self) -> None:
        """End the sessions of all who are away."""
        for kept in tuple(self._kept.values()):
            if kept.seat is None:
                self._end(kept)

    # -- a socket comes ------------------------------------------------------------------------------------------------

    async def enter(self, user: str, visit: Visit, probe: Probe) -> Seat:
        """Return a seat at the place of a robot, once its container is ready; whoever gets it must ``leave``.

        Raises
        ------
        Conflict
            The robot is connected already, and answers.
        PPaaSError
            As the place says; see ``RobotSessions.join`` and ``PlaceLink.ready``.
        """
        if visit.role == "robot":
            await self._make_way(user, visit)
        place = await self._robots.join(
            user, visit.robot, as_robot=visit.role == "robot", hold=visit.hold, queue=visit.queue
        )
        try:
            await self._ready(visit, place)
            seat = await self._seat(user, visit, place, probe)
        except BaseException:
            self._leave_place(place, visit)
            raise
        self._seats.add(seat)
        if self._robots.position(place) is not None:
            self._telling.run(self._tell_position(seat))
        return seat

    async def _ready(self, visit: Visit, place: PlaceLink) -> None:
        position = self._robots.position(place)
        if position is None:
            await place.ready(READY_TIMEOUT)
        elif not visit.queue:
            raise Unavailable(f"the robot waits at position {position} of the queue: connect with queue=1 to wait, too")

    async def _tell_position(self, seat: Seat) -> None:
        told = None
        while not seat.has_left and (position := self._robots.position(seat.kept.place)) is not None:
            if position != told:
                seat.session.inform("queued", f"position {position} in the queue")
                told = position
            await asyncio.sleep(POSITION_PERIOD)
        if not seat.has_left:
            seat.session.inform("queued", "it is this robot's turn: its container starts")

    async def _make_way(self, user: str, visit: Visit) -> None:
        """Take the robot's place from a socket of the same session, or from one that is dead."""
        for seat in self.seats():
            if (seat.user, seat.visit.robot, seat.visit.role) != (user, visit.robot, "robot"):
                continue
            if visit.session is not None and visit.session == seat.visit.session:
                await seat.evict(Conflict("another connection of the same session took over"))
            elif not await seat.answers():
                await seat.evict(Conflict("it did not answer, and another connection of this robot came"))

    async def _seat(self, user: str, visit: Visit, place: PlaceLink, probe: Probe) -> Seat:
        key = SessionKey(user, visit.robot, visit.role, visit.session) if visit.session is not None else None
        kept = await self._free(key) if key is not None else None
        # No await from here on: whoever finds the session free has it.
        if kept is not None and not self._may_resume(kept, visit, place):
            self._end(kept)
            kept = None
        resumed = kept is not None
        if kept is None:
            kept = self._begin(user, visit, place, key)
        elif visit.resume is not None:
            kept.session.outbox.resume(visit.resume.received)
        if kept.expiry is not None:
            kept.expiry.cancel()
        seat = kept.seat = Seat(kept, visit, user, probe, resumed=resumed)
        return seat

    async def _free(self, key: SessionKey) -> Kept | None:
        while (kept := self._kept.get(key)) is not None and kept.seat is not None:
            await kept.seat.evict(Conflict("another connection of the same session took over"))
        return kept

    @staticmethod
    def _may_resume(kept: Kept, visit: Visit, place: PlaceLink) -> bool:
        if kept.place is not place or kept.session.over.done():
            return False
        return not visit.counts or (visit.resume is not None and visit.resume.id == kept.id)

    def _begin(self, user: str, visit: Visit, place: PlaceLink, key: SessionKey | None) -> Kept:
        wire = rosbridge.RosbridgeSession("info" if visit.queue else "error" if visit.status else "none")
        count_plan = partial(self._plan_rate.take, user)
        session = ClientSession(place, visit.role, wire, f"{visit.role} {user}/{visit.robot}", count_plan)
        session.outbox.repeats = visit.counts
        kept = Kept(session, place, key)
        if key is not None:
            self._kept[key] = kept
            session.over.add_done_callback(lambda _: self._end(kept) if kept.seat is None else None)
        return kept

    # -- a socket goes -------------------------------------------------------------------------------------------------

    def leave(self, seat: Seat, *, for_good: bool) -> None:
        """Give a seat up; the session is kept for a while, if it has a name and its client may come back."""
        kept = seat.kept
        seat.leave()
        self._seats.discard(seat)
        self._leave_place(kept.place, seat.visit)
        if kept.key is None or for_good or kept.session.over.done():
            self._end(kept)
            return
        self._kept[kept.key] = self._kept.pop(kept.key)  # behind those that went before
        kept.expiry = asyncio.get_running_loop().call_later(self._linger, self._end, kept)
        away = [other for key, other in self._kept.items() if key.user == seat.user and other.seat is None]
        for other in away[:-MAX_AWAY]:
            self._end(other)

    def _leave_place(self, place: PlaceLink, visit: Visit) -> None:
        if visit.hold:
            self._robots.leave(place, as_robot=visit.role == "robot")

    def _end(self, kept: Kept) -> None:
        if kept.ended:
            return
        kept.ended = True
        if kept.key is not None and self._kept.get(kept.key) is kept:
            del self._kept[kept.key]
        if kept.expiry is not None:
            kept.expiry.cancel()
        kept.session.end()
