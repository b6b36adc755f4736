"""Registry of all client sessions: attached to a socket, or detached and waiting for their client to reconnect.

A named session outlives its sockets. Its subscriptions, waiting frames and pending requests are retained for some time
after the socket closed, and passed to the next socket that names the session. A socket that names an attached session
takes it over: the client knows best whether its old socket is dead.
"""

import asyncio
from collections.abc import Iterable
from functools import partial

from endpoints.http.websocket_protocol import Probe
from endpoints.rosbridge.attachment import Attachment, RetainedSession, SessionKey, name_of
from endpoints.rosbridge.connect_request import ConnectRequest
from engine.processes.background import Background
from engine.service.plan_rate import PlanRate
from engine.service.robot_sessions import LINGER, RobotSessions
from engine.sessions.namespaces import scope_of
from engine.sessions.place.place_link import PlaceLink
from engine.sessions.rights.access import Access
from engine.sessions.session import ClientSession
from ppaas.errors import Conflict, Unavailable
from ppaas.wire import rosbridge
from ppaas.wire.binary.packing import Packer
from ppaas.wire.operations import Level
from ppaas.wire.ros.serialization import serialize

READY_TIMEOUT = 15.0
"""Time limit until the container of a place is ready [s]."""

POSITION_PERIOD = 0.5
"""Interval of checks of a robot's position in the queue [s]."""

MAX_AWAY = 64
"""Largest number of detached sessions of one user; the oldest detached session is evicted first."""


class SessionRegistry:
    """Attaches sockets to sessions.

    Parameters
    ----------
    robots : RobotSessions
        Opens the places.
    plan_rate : PlanRate
        Limits the path requests of clients.
    linger : float
        Time for which a detached session is retained [s].
    """

    def __init__(self, robots: RobotSessions, plan_rate: PlanRate, linger: float = LINGER) -> None:
        self._robots = robots
        self._plan_rate = plan_rate
        self._linger = linger
        self._retained: dict[SessionKey, RetainedSession] = {}
        self._attachments: set[Attachment] = set()
        self._background = Background()

    def attachments(self) -> Iterable[Attachment]:
        """Return the attachments of all connected sockets."""
        return tuple(self._attachments)

    @property
    def away(self) -> int:
        """Number of detached sessions."""
        return sum(retained.attachment is None for retained in self._retained.values())

    def close(self) -> None:
        """End all detached sessions."""
        for retained in tuple(self._retained.values()):
            if retained.attachment is None:
                self._end(retained)

    # -- attaching ----------------------------------------------------------------------------------------------------

    async def attach(self, user: str, token: str, request: ConnectRequest, probe: Probe, access: Access) -> Attachment:
        """Attach a socket to a session at the place of a robot, once its container is ready; `detach` must follow.

        Parameters
        ----------
        user, token : str
            User of the client, and id of the token that it authenticated with.
        request : ConnectRequest
            Request of the client.
        probe : callable
            Probes the connection.
        access : Access
            Rights of the client on the robot.

        Raises
        ------
        Conflict
            The robot is connected already, and its socket answers.
        PPaaSError
            The place is not available; see ``RobotSessions.join`` and ``PlaceLink.ready``.
        """
        owner = request.owner or user
        if request.role == "robot":
            await self._displace(owner, request)
        place = await self._robots.join(
            owner, request.robot, as_robot=request.role == "robot", hold=request.hold, queue=request.queue
        )
        try:
            await self._wait_ready(request, place)
            attachment = await self._attach(user, token, request, place, probe, access=access)
        except BaseException:
            self._leave_place(place, request)
            raise
        self._attachments.add(attachment)
        if self._robots.position(place) is not None:
            self._background.run(self._report_position(attachment))
        return attachment

    async def _wait_ready(self, request: ConnectRequest, place: PlaceLink) -> None:
        position = self._robots.position(place)
        if position is None:
            await place.ready(READY_TIMEOUT)
        elif not request.queue:
            raise Unavailable(f"the robot is at position {position} in the queue: connect with queue=1 to wait for it")

    async def _report_position(self, attachment: Attachment) -> None:
        reported = None
        while not attachment.has_left and (position := self._robots.position(attachment.retained.place)) is not None:
            if position != reported:
                attachment.session.inform("queued", f"position {position} in the queue")
                reported = position
            await asyncio.sleep(POSITION_PERIOD)
        if not attachment.has_left:
            attachment.session.inform("queued", "the robot left the queue: its container starts")

    async def _displace(self, owner: str, request: ConnectRequest) -> None:
        """Displace a robot's socket of the same session, or one that is dead."""
        for attachment in self.attachments():
            if (attachment.owner, attachment.request.robot, attachment.request.role) != (owner, request.robot, "robot"):
                continue
            if request.session is not None and request.session == attachment.request.session:
                await attachment.take_over(Conflict("another connection of the same session took over"))
            elif not await attachment.answers():
                await attachment.take_over(
                    Conflict("it did not answer, and another connection of this robot replaced it")
                )

    async def _attach(
        self, user: str, token: str, request: ConnectRequest, place: PlaceLink, probe: Probe, *, access: Access
    ) -> Attachment:
        name = request.session
        key = None if name is None else SessionKey(user, request.owner or user, request.robot, request.role, name)
        retained = await self._take_free(key) if key is not None else None
        # No await from here on: otherwise two sockets could take the same session.
        if retained is not None and not self._may_resume(retained, request, place, access):
            self._end(retained)
            retained = None
        resumed = retained is not None
        if retained is None:
            retained = self._begin(user, request, place, key, access)
        elif request.resume is not None:
            retained.session.outbox.resume(request.resume.received)
        if retained.expiry is not None:
            retained.expiry.cancel()
        retained.session.access = access
        attachment = retained.attachment = Attachment(retained, request, user, token, probe, resumed=resumed)
        return attachment

    async def _take_free(self, key: SessionKey) -> RetainedSession | None:
        while (retained := self._retained.get(key)) is not None and retained.attachment is not None:
            await retained.attachment.take_over(Conflict("another connection of the same session took over"))
        return retained

    @staticmethod
    def _may_resume(retained: RetainedSession, request: ConnectRequest, place: PlaceLink, access: Access) -> bool:
        if retained.place is not place or retained.session.over.done():
            return False
        if not access.includes(retained.session.access):  # it may hold what the client has no right to any more
            return False
        return not request.counts or (request.resume is not None and request.resume.id == retained.id)

    def _begin(
        self, user: str, request: ConnectRequest, place: PlaceLink, key: SessionKey | None, access: Access
    ) -> RetainedSession:
        level: Level = "info" if request.queue else "error" if request.status else "none"
        packer = Packer(compact=request.compact, png=request.png, serialize=serialize)
        wire = rosbridge.RosbridgeSession(level, scope_of(request.robot, request.namespace), packer)
        count_plan = partial(self._plan_rate.take, user)
        session = ClientSession(place, request.role, wire, name_of(user, request), count_plan, access=access)
        session.outbox.repeats = request.counts
        retained = RetainedSession(session, place, key)
        if key is not None:
            self._retained[key] = retained
            session.over.add_done_callback(lambda _: self._end(retained) if retained.attachment is None else None)
        return retained

    # -- detaching ----------------------------------------------------------------------------------------------------

    def detach(self, attachment: Attachment, *, for_good: bool) -> None:
        """Detach a socket; a named session is retained for a while, unless its client left for good."""
        retained = attachment.retained
        attachment.detach()
        self._attachments.discard(attachment)
        self._leave_place(retained.place, attachment.request)
        if retained.key is None or for_good or retained.session.over.done():
            self._end(retained)
            return
        self._retained[retained.key] = self._retained.pop(
            retained.key
        )  # moves to the end: the order is that of detaching
        retained.expiry = asyncio.get_running_loop().call_later(self._linger, self._end, retained)
        of_user = [other for key, other in self._retained.items() if key.user == attachment.user]
        away = [other for other in of_user if other.attachment is None]
        for other in away[:-MAX_AWAY]:
            self._end(other)

    def _leave_place(self, place: PlaceLink, request: ConnectRequest) -> None:
        if request.hold:
            self._robots.leave(place, as_robot=request.role == "robot")

    def _end(self, retained: RetainedSession) -> None:
        if retained.ended:
            return
        retained.ended = True
        if retained.key is not None and self._retained.get(retained.key) is retained:
            del self._retained[retained.key]
        if retained.expiry is not None:
            retained.expiry.cancel()
        retained.session.end()
