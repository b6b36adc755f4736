"""Registry of the sockets that this endpoint has, each attached to a session in the container of its place.

A socket that names an attached session takes it over: the client knows best whether its old socket is dead.
"""

import asyncio
from collections.abc import Callable, Iterable
from functools import partial

from endpoints.rosbridge.attachment import Attachment, Caller
from endpoints.rosbridge.connect_request import ConnectRequest
from endpoints.services.robot_places import RobotPlaces
from engine.master.places import LINGER
from engine.processes.background import Background
from engine.protocols.session_frames import SessionOptions
from engine.rights.access import Access
from engine.service.endpoints.control_plane import CountPaths
from engine.service.links.carried_session import CarriedSession
from engine.service.links.place_link import PlaceLink
from engine.specs.start_state import READY, StartState, explained
from ppaas.errors import Conflict, PPaaSError, Unavailable
from ppaas.wire.operations import Level

READY_TIMEOUT = 15.0
"""Time limit until the container of a place is ready [s]."""

POSITION_PERIOD = 0.5
"""Interval of checks of a robot's position in the queue [s]."""


class SessionRegistry:
    """Attaches sockets to sessions.

    Parameters
    ----------
    robots : RobotPlaces
        Opens the places.
    count_paths : callable
        Counts paths that a user requests; raises if they exceed the quota.
    linger : float
        Time for which a detached session is retained [s].
    start_of : callable
        Returns whether containers can start, and the kernels that machines compile.
    """

    def __init__(
        self,
        robots: RobotPlaces,
        count_paths: CountPaths,
        linger: float = LINGER,
        start_of: Callable[[], StartState] = lambda: READY,
    ) -> None:
        self._start_of = start_of
        self._robots = robots
        self._count_paths = count_paths
        self._linger = linger
        self._attachments: set[Attachment] = set()
        self._counted: dict[Attachment, int] = {}
        self._counted_at = 0.0
        self._background = Background()

    def attachments(self) -> Iterable[Attachment]:
        """Return the attachments of all connected sockets."""
        return tuple(self._attachments)

    def load(self) -> tuple[int, float]:
        """Return the number of sockets, and the frames of clients since the last call [1/s]."""
        now = asyncio.get_running_loop().time()
        taken = {attachment: attachment.session.taken for attachment in self._attachments}
        fresh = sum(count - self._counted.get(attachment, 0) for attachment, count in taken.items())
        rate = max(fresh, 0) / max(now - self._counted_at, 1e-3)
        self._counted, self._counted_at = taken, now
        return len(taken), rate

    # -- attaching ----------------------------------------------------------------------------------------------------

    async def attach(self, caller: Caller, request: ConnectRequest, access: Access) -> Attachment:
        """Attach a socket to a session at the place of a robot, once its container is ready; `detach` must follow.

        Parameters
        ----------
        caller : Caller
            The client.
        request : ConnectRequest
            Request of the client.
        access : Access
            Rights of the client on the robot.

        Raises
        ------
        Conflict
            The robot is connected already, and its socket answers.
        PPaaSError
            The place is not available; see ``RobotSessions.join`` and ``PlaceLink.ready``.
        """
        owner = request.owner or caller.user
        if request.role == "robot":
            await self.displace(owner, request.robot, request.session)
        with explained(self._start_of):
            place = await self._robots.join(
                owner, request.robot, as_robot=request.role == "robot", hold=request.hold, queue=request.queue,
                session=request.session,
            )  # fmt: skip
        try:
            queued = await self._wait_ready(request, place)
            attachment = await self._attach(caller, request, place, access, queued=queued)
        except BaseException:
            self._leave_place(place, request)
            raise
        if queued:
            self._background.run(self._report_position(attachment))
        return attachment

    async def _wait_ready(self, request: ConnectRequest, place: PlaceLink) -> bool:
        """Wait for the container of a place; return whether the place is queued instead, as its client accepts."""
        position = await self._robots.position(place)
        if position is None:
            await place.ready(READY_TIMEOUT, self._why)
        elif not request.queue:
            raise Unavailable(f"the robot is at position {position} in the queue: connect with queue=1 to wait for it")
        return position is not None

    def _why(self) -> PPaaSError | None:
        """Return why no container was ready in time, if kernels are the reason."""
        return self._start_of().refusal()

    async def _report_position(self, attachment: Attachment) -> None:
        reported = None
        while not attachment.has_left and (position := await self._robots.position(attachment.place)) is not None:
            if position != reported:
                attachment.session.inform("queued", f"position {position} in the queue")
                reported = position
            await asyncio.sleep(POSITION_PERIOD)
        if not attachment.has_left:
            attachment.session.inform("queued", "the robot left the queue: its container starts")

    async def displace(self, owner: str, robot: str, session: str | None) -> None:
        """Displace a robot's socket of the same session, or one that is dead."""
        for attachment in self.attachments():
            if (attachment.owner, attachment.request.robot, attachment.request.role) != (owner, robot, "robot"):
                continue
            if session is not None and session == attachment.request.session:
                await attachment.take_over(Conflict("another connection of the same session took over"))
            elif not await attachment.answers():
                await attachment.take_over(
                    Conflict("it did not answer, and another connection of this robot replaced it")
                )

    async def _attach(
        self, caller: Caller, request: ConnectRequest, place: PlaceLink, access: Access, *, queued: bool
    ) -> Attachment:
        await self._take_over(caller.user, request)
        session = CarriedSession(
            place, request.client(caller.user), self._options_of(request), access, request.resume,
            count_plan=partial(self._count_paths, caller.user, 1),
        )  # fmt: skip
        attachment = Attachment(session, place, request, caller)
        self._attachments.add(attachment)
        try:
            if queued and place.container is None:
                session.begin_without_container()
            else:
                session.attach()
                await session.attached(READY_TIMEOUT, self._why)
        except BaseException:
            self._attachments.discard(attachment)
            attachment.detach(for_good=True)
            raise
        return attachment

    async def _take_over(self, user: str, request: ConnectRequest) -> None:
        """Displace the socket here that the session has now."""
        if request.session is None:
            return
        wanted = request.client(user)

        def has_it(attachment: Attachment) -> bool:
            return attachment.request.client(attachment.user) == wanted

        while (attachment := next(filter(has_it, self._attachments), None)) is not None:
            await attachment.take_over(Conflict("another connection of the same session took over"))

    def _options_of(self, request: ConnectRequest) -> SessionOptions:
        level: Level = "info" if request.queue else "error" if request.status else "none"
        return SessionOptions(level, request.namespace, request.compact, request.png, request.counts, self._linger)

    # -- detaching ----------------------------------------------------------------------------------------------------

    def detach(self, attachment: Attachment, *, for_good: bool) -> None:
        """Detach a socket; a named session is retained for a while, unless its client left for good."""
        self._attachments.discard(attachment)
        attachment.detach(for_good=for_good or attachment.session.over.done())
        self._leave_place(attachment.place, attachment.request)

    def _leave_place(self, place: PlaceLink, request: ConnectRequest) -> None:
        if request.hold:
            self._robots.leave(place.key, as_robot=request.role == "robot")
