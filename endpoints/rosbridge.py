"""Robot WebSocket: ``ws://HOST/?robot=ID&role=robot|operator&session=NAME``, speaking rosbridge v2.

From top to bottom: the request in the address, the admission to the robot, the attachment of the socket to a session in
the container of its place, the registry of the sockets of this endpoint, the watch that ends sessions whose user lost
a right, and the socket. A client whose user has one robot need not name it. A connection is refused before the
handshake is complete, with an HTTP problem.
"""

import asyncio
import logging
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple, Protocol

from starlette.concurrency import run_in_threadpool
from starlette.websockets import WebSocket, WebSocketState

from endpoints.accounts.authentication import authenticate_socket, subprotocol_of
from endpoints.accounts.tokens import ScopedUser
from endpoints.audit.requests import note_object
from endpoints.http.problems import problem_response
from endpoints.http.websocket_protocol import Probe, close_with, connection_of
from endpoints.resources.services import Services
from endpoints.sharing.access import access_of
from endpoints.sharing.shared_robots import own_robots
from engine.control.master_calls.control_plane import CountPaths
from engine.links.carried_session import CarriedSession
from engine.links.place_link import PlaceLink
from engine.master.places import LINGER
from engine.processes.background import Background, repeat
from engine.protocols.session_frames import SessionClient, SessionOptions
from engine.rights.access import Access
from engine.rights.globs import split_address
from engine.rights.roles import Role, role_of
from engine.sessions.namespaces import parse_namespace
from engine.specs.start_state import READY, StartState, explained
from ppaas.errors import Conflict, InvalidParameter, NotAuthenticated, NotFound, NotPermitted, PPaaSError, Unavailable
from ppaas.wire.operations import Level
from ppaas.wire.resumption import (
    ENDPOINT_HEADER,
    ID_HEADER,
    LEFT,
    NEW,
    RESUME,
    RESUMED,
    SESSION,
    STATE_HEADER,
    TAKEN_HEADER,
    ResumptionPoint,
    parse_name,
    parse_point,
)
from storage.ports import RobotStore
from storage.records import RobotRecord, User
from storage.sharing_records import Share

logger = logging.getLogger(__name__)


# Connect request of a client: the query in the address of its WebSocket.


@dataclass(frozen=True, slots=True)
class ConnectRequest:
    """Parameters of a client's connection to a robot.

    Parameters
    ----------
    robot : str
        Id of the robot; empty if the client names none, which the only robot of its user need not be.
    owner : str
        User to whom the robot belongs; empty for the user of the client.
    role : {"robot", "operator"}
        Role of the client.
    session : str, optional
        Name of the client's session; without one, the session ends with the socket.
    resume : ResumptionPoint, optional
        Point at which the client resumes this session.
    counts : bool
        Whether the client counts frames: it resumes exactly at that point, or starts a new session.
    hold : bool
        Whether the place is opened and kept open for this client.
    status : bool
        Whether errors are reported to the client from the start.
    queue : bool
        Whether the client waits in the queue if no container is available now, and is notified of its position.
    namespace : str, optional
        Namespace of the robot's names in the client's software.
    compact : bool
        Whether velocities are sent to the client as compact frames.
    png : bool
        Whether the client reads the operation ``png`` if it asks for it.
    software : str
        Software of the client, as it names it; empty if it does not.
    """

    robot: str
    role: Role = "robot"
    session: str | None = None
    resume: ResumptionPoint | None = None
    counts: bool = False
    hold: bool = True
    status: bool = False
    queue: bool = False
    owner: str = ""
    namespace: str | None = None
    compact: bool = False
    png: bool = True
    software: str = ""

    def client(self, user: str) -> SessionClient:
        """Return the client of a session, which is this user."""
        return SessionClient(user, self.owner or user, self.robot, self.role, self.session)


def parse_connect_request(query: Mapping[str, str]) -> ConnectRequest:
    """Return the connect request in the query of an address.

    Raises
    ------
    InvalidParameter
        A parameter is invalid.
    """
    role = role_of(query.get("role", "robot"))
    robot = query.get("robot")
    if robot == "":
        raise InvalidParameter("the parameter 'robot' is empty: open ws://HOST/?robot=ID")
    owner, robot = split_address(robot or "", "")
    if owner and not robot:
        raise InvalidParameter(f"the parameter 'robot' names no robot of {owner[:64]!r}: give OWNER:ID")
    session, resume = query.get(SESSION), query.get(RESUME)
    if resume is not None and session is None:
        raise InvalidParameter(f"{RESUME!r} needs the name of a session: also give 'session'")
    hold = query.get("hold", "1")
    if hold not in ("0", "1"):
        raise InvalidParameter(f"hold must be 0 or 1, not {hold[:32]!r}")
    if hold == "0" and role == "robot":
        raise InvalidParameter("hold=0 is for operators only: a robot always holds its place")
    return ConnectRequest(
        robot=robot,
        owner=owner,
        role=role,
        session=parse_name(session) if session is not None else None,
        resume=parse_point(resume) if resume is not None else None,
        counts=resume is not None,
        hold=hold == "1",
        status=query.get("status") == "1",
        queue=query.get("queue") == "1",
        namespace=parse_namespace(query["namespace"]) if "namespace" in query else None,
        compact=query.get("compact") == "1",
        software=parse_software(query.get("software", "")),
    )


LONGEST_SOFTWARE = 128
"""Longest name of a client's software [characters]."""


def parse_software(name: str) -> str:
    """Return the name of a client's software.

    Raises
    ------
    InvalidParameter
        It is too long, or has characters that are not printable.
    """
    if len(name) > LONGEST_SOFTWARE or not name.isprintable():
        raise InvalidParameter(f"software must be at most {LONGEST_SOFTWARE} printable characters")
    return name


def software_of(agent: str) -> str:
    """Return the name of a client's software from its ``User-Agent``, as far as it is printable."""
    return "".join(filter(str.isprintable, agent))[:LONGEST_SOFTWARE]


# Admission of clients to robots: their own, and those that are shared with them.


async def admitted(services: Services, user: User, request: ConnectRequest) -> tuple[ConnectRequest, Access]:
    """Return the request of a client, and the client's rights on the robot.

    A client that may only look neither opens a place nor keeps it open: containers count for the owner of the robot.

    Raises
    ------
    NotFound
        The robot does not exist, or is neither the user's nor shared with the user.
    NotPermitted
        The user or the token has no right to connect in this role.
    """
    owner = request.owner or user.id
    if is_owner(user, owner):
        return request, Access.of_owner(request.robot)
    shares: tuple[Share, ...] = ()
    if owner != user.id:
        try:
            shares = (await run_in_threadpool(services.store.robot, owner, request.robot)).shares
        except NotFound as error:
            raise NotFound("robot", f"{owner}:{request.robot}") from error
    access = access_of(user, owner, request.robot, shares)
    access.check_connect(as_robot=request.role == "robot")
    if owner != user.id:
        limits = (await run_in_threadpool(services.store.user, owner)).limits
        await services.cloud.set_limits(owner, limits)
    opens = request.role == "robot" or access.role != "look"
    return (request if opens else replace(request, hold=False)), access


async def current_access(services: Services, user: User, owner: str, robot: str) -> Access:
    """Return the rights of a connected client now; reads of the store are cached.

    Raises
    ------
    NotFound, NotPermitted
        As ``access_of``.
    Unavailable
        They cannot be read now.
    """
    own = owner == user.id or user.role == "admin"
    shares = () if own else await services.shares.shares(services.store, owner, robot)
    return access_of(user, owner, robot, shares)


def is_owner(user: User, owner: str) -> bool:
    """Return whether a caller is the owner of a robot, with all rights: the token has no scope."""
    return owner == user.id and not isinstance(user, ScopedUser)


# Robot of a client that names none: the only one of its user.

MAX_LISTED = 10
"""Largest number of robots that the refusal lists."""


async def only_robot(store: RobotStore, user: User) -> str:
    """Return the id of the only robot of a user, or the only one that the user's token is for.

    Raises
    ------
    InvalidParameter
        The user has none, or several, which the text lists.
    """
    robots = [robot.id for robot in await run_in_threadpool(_first_robots, store, user)]
    if len(robots) == 1:
        return robots[0]
    if not robots:
        raise InvalidParameter(
            f"user {user.id!r} has no robot yet: register one with 'ppaas robot put' or PUT /v1/robots/ID"
        )
    listed = ", ".join(robots[:MAX_LISTED]) + (", …" if len(robots) > MAX_LISTED else "")
    raise InvalidParameter(f"user {user.id!r} has several robots: open ws://HOST/?robot=ID with one of {listed}")


def _first_robots(store: RobotStore, user: User) -> list[RobotRecord]:
    return own_robots(store, user, limit=MAX_LISTED + 1)


# Attachment of a socket to a session in the container of its place.

PROBE_TIMEOUT = 2.0
"""Time limit of the probe of a robot's socket when another socket connects for the same robot [s]."""


class AuthenticatedClient(NamedTuple):
    """User of a client, id of the token that it authenticated with, and the probe of its connection."""

    user: str
    token: str
    probe: Probe


class Attachment:
    """Attachment of one socket to a session.

    Parameters
    ----------
    session : CarriedSession
        The session, as this endpoint carries it.
    place : PlaceLink
        Place of the robot.
    request : ConnectRequest
        Request of the client.
    caller : AuthenticatedClient
        The client.

    Attributes
    ----------
    user, token : str
        User of the client, and id of the token that it authenticated with.
    """

    def __init__(
        self, session: CarriedSession, place: PlaceLink, request: ConnectRequest, caller: AuthenticatedClient
    ) -> None:
        self.session = session
        self.place = place
        self.request = request
        self.user, self.token, self._probe = caller
        self._left = asyncio.Event()

    @property
    def owner(self) -> str:
        """User to whom the robot belongs."""
        return self.request.owner or self.user

    @property
    def headers(self) -> list[tuple[bytes, bytes]]:
        """Headers of the handshake for a client that named its session."""
        if self.request.session is None:
            return []
        state = {
            STATE_HEADER: RESUMED if self.session.resumed else NEW,
            ID_HEADER: self.session.id,
            TAKEN_HEADER: str(self.session.taken),
        }
        if self.place.nearer:
            state[ENDPOINT_HEADER] = self.place.nearer
        return [(name.encode(), value.encode()) for name, value in state.items()]

    @property
    def displaced(self) -> asyncio.Future[PPaaSError]:
        """Future that is done once another socket took over the session; its result is the reason."""
        return self.session.displaced

    async def answers(self) -> bool:
        """Return whether the client is alive: it answers a ping or sends a frame meanwhile."""
        taken = self.session.taken
        return await self._probe(PROBE_TIMEOUT) or self.session.taken != taken

    async def take_over(self, why: PPaaSError) -> None:
        """Displace this socket, and wait until it is detached from the session."""
        self.session.displace(why)
        await self._left.wait()

    @property
    def has_left(self) -> bool:
        """Whether the socket is detached or the session is over."""
        return self._left.is_set() or self.session.over.done()

    def detach(self, *, for_good: bool) -> None:
        """Detach the socket from the session, which is retained for a while unless the client left for good."""
        self._left.set()
        self.session.detach(for_good=for_good)


# Places of robots, as the engine opens them for sockets.


class RobotPlaces(Protocol):
    """Places of robots, as endpoints see them; see ``engine.control.robot_sessions.RobotSessions``."""

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
        """Add a client to the place of a robot and return the place; with ``hold``, the client must ``leave`` it later.

        Raises
        ------
        NotFound
            The user has no such robot, or its map was deleted.
        InvalidParameter
            A mask that the robot's file names does not exist, or is not a grid; or a robot with a new map has one.
        NotPermitted
            The user may no longer read the map.
        Conflict
            The robot is connected already.
        QuotaExceeded, Unavailable
            No container is available.
        """
        ...

    def leave(self, key: str, *, as_robot: bool) -> None:
        """Remove a client from a place."""
        ...

    async def position(self, place: PlaceLink) -> int | None:
        """Return the position of a place in the queue, from 1; None if it is not queued."""
        ...

    async def let_go(self, place: PlaceLink, reason: PPaaSError) -> None:
        """Close a place although clients are connected, and notify them of the reason."""
        ...


# Registry of the sockets that this endpoint has, each attached to a session in the container of its place.
#
# A socket that names an attached session takes it over: the client knows best whether its old socket is dead.

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

    async def attach(self, caller: AuthenticatedClient, request: ConnectRequest, access: Access) -> Attachment:
        """Attach a socket to a session at the place of a robot, once its container is ready; `detach` must follow.

        Parameters
        ----------
        caller : AuthenticatedClient
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
        self, caller: AuthenticatedClient, request: ConnectRequest, place: PlaceLink, access: Access, *, queued: bool
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
        if request.session is None:
            return
        wanted = request.client(user)

        def has_it(attachment: Attachment) -> bool:
            return attachment.request.client(attachment.user) == wanted

        while (attachment := next(filter(has_it, self._attachments), None)) is not None:
            await attachment.take_over(Conflict("another connection of the same session took over"))

    def _options_of(self, request: ConnectRequest) -> SessionOptions:
        level: Level = "info" if request.queue else "error" if request.status else "none"
        return SessionOptions(
            level, request.namespace, request.compact, request.png, request.counts, self._linger, request.software
        )

    # -- detaching ----------------------------------------------------------------------------------------------------

    def detach(self, attachment: Attachment, *, for_good: bool) -> None:
        """Detach a socket; a named session is retained for a while, unless its client left for good."""
        self._attachments.discard(attachment)
        attachment.detach(for_good=for_good or attachment.session.over.done())
        self._leave_place(attachment.place, attachment.request)

    def _leave_place(self, place: PlaceLink, request: ConnectRequest) -> None:
        if request.hold:
            self._robots.leave(place.key, as_robot=request.role == "robot")


# Rights watch: ends the sessions of users who lost a right that they had when they connected.
#
# It polls, instead of being notified, so it also sees what another process changed in the store. The caches of tokens
# and maps drop what this process changes at once; what another process changes is seen when their entries expire.

PERIOD = 0.5
"""Interval of the checks [s]."""


class RightsWatch:
    """Ends sessions whose token was revoked or has expired.

    A session at a robot of another user ends when the robot is no longer shared with the client's user; also when it is
    shared for less, whereupon the client connects again and has what is left.

    Parameters
    ----------
    sessions : SessionRegistry
        Sessions of all clients.
    services : Services
        Services with the accounts.
    """

    def __init__(self, sessions: SessionRegistry, services: Services) -> None:
        self._sessions = sessions
        self._services = services

    async def run(self) -> None:
        """Check all sessions periodically until cancelled."""
        await repeat(self.check, PERIOD)

    async def check(self) -> None:
        """Check all sessions once; a right that cannot be checked now, as its store is unreachable, remains."""
        by_token: defaultdict[str, list[Attachment]] = defaultdict(list)
        for attachment in self._sessions.attachments():
            by_token[attachment.token].append(attachment)
        await asyncio.gather(*(self._check_token(token, attachments) for token, attachments in by_token.items()))

    async def _check_token(self, token: str, attachments: list[Attachment]) -> None:
        try:
            user = await self._services.accounts.user_of(token)
        except NotAuthenticated as error:
            for attachment in attachments:
                attachment.session.closed(error)
        except Unavailable:
            return
        else:
            limited = (one for one in attachments if not is_owner(user, one.owner) or not one.session.access.is_full)
            await asyncio.gather(*(self._check_access(user, attachment) for attachment in limited))

    async def _check_access(self, user: User, attachment: Attachment) -> None:
        """End a session whose user lost rights on the robot; give it those that are new."""
        session, robot = attachment.session, attachment.request.robot
        try:
            access = await current_access(self._services, user, attachment.owner, robot)
            access.check_connect(as_robot=attachment.request.role == "robot")
        except Unavailable:
            return
        except NotFound:
            if attachment.owner != user.id:
                session.closed(NotPermitted(f"robot {robot!r} of {attachment.owner!r} is not shared with {user.id!r}"))
        except NotPermitted as error:
            session.closed(error)
        else:
            if access.includes(session.access):
                session.access = access
            else:  # what it subscribed to and offers may be more than it may have now
                session.closed(Unavailable(f"your rights on robot {robot!r} were changed: connect again"))


# The socket, from its handshake to its end.

TAKEN_OVER = 4409
"""Close code: another socket took over the session."""


class RobotSocket:
    """One WebSocket of a client.

    Parameters
    ----------
    socket : WebSocket
        Accepted WebSocket.
    attachment : Attachment
        Attachment to the session whose frames it carries.

    Attributes
    ----------
    left : bool
        Whether the client reported, in the close frame, that it will not reconnect.
    """

    def __init__(self, socket: WebSocket, attachment: Attachment) -> None:
        self._socket = socket
        self._connection = connection_of(socket)
        self._attachment = attachment
        self._session = attachment.session
        self.left = False

    async def run(self) -> None:
        """Carry frames until the client disconnects, its place closes, or another socket takes over its session."""
        session = self._session
        self._connection.hand_to(session.take, session.flush)
        session.connect(self._connection)
        left = asyncio.create_task(self._until_left())
        try:
            ends = (left, session.over, self._attachment.displaced)
            await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
        finally:
            session.connect(None)
            self._connection.hand_to(None)
            left.cancel()
            await asyncio.gather(left, return_exceptions=True)

    async def _until_left(self) -> None:
        while (message := await self._socket.receive())["type"] != "websocket.disconnect":
            content, binary = content_of(message)
            self._session.take(content, binary=binary)  # received before the handshake was answered
        self.left = message.get("reason") == LEFT

    async def close_with_reason(self) -> None:
        """Close the socket with the reason, unless the client closed it."""
        if self._socket.application_state is not WebSocketState.CONNECTED:
            return
        if self._attachment.displaced.done():
            await close_with(self._socket, self._attachment.displaced.result(), TAKEN_OVER)
        elif self._session.over.done():
            await close_with(self._socket, self._session.over.result())


def content_of(message: Mapping[str, Any]) -> tuple[bytes, bool]:
    """Return the content of a message of ASGI, text in UTF-8, and whether it is binary."""
    text: str | None = message.get("text")
    return (text.encode(), False) if text is not None else (bytes(message.get("bytes") or b""), True)


def reads_png(agent: str) -> bool:
    """Return whether a client with this ``User-Agent`` may be sent the operation ``png``.

    ``roslibpy`` offers the compression and cannot read it; it is known by the two libraries whose sockets it uses.
    """
    return not re.match(r"AutobahnPython/|Python/\S+ websockets/", agent)


async def serve_robot_socket(socket: WebSocket, services: Services, sessions: SessionRegistry) -> None:
    """Serve one WebSocket from its handshake to its end."""
    connection = connection_of(socket)
    connection.name = f"unknown user at robot {socket.query_params.get('robot', '')[:64]!r}"
    try:
        request = parse_connect_request(socket.query_params)
        user, token = await authenticate_socket(socket, services.accounts)
        if not request.robot:
            request = replace(request, robot=await only_robot(services.store, user))
            note_object(socket.scope, f"robots/{request.robot}")
        agent = socket.headers.get("user-agent", "")
        request = replace(request, png=reads_png(agent), software=request.software or software_of(agent))
        connection.name = request.client(user.id).title
        await services.cloud.set_limits(user.id, user.limits)
        request, access = await admitted(services, user, request)
        with services.refused_connects.attempt(request.owner or user.id, request.robot, request.role):
            attachment = await sessions.attach(AuthenticatedClient(user.id, token, connection.probe), request, access)
    except PPaaSError as error:
        connection.warn(f"refused: {error.slug}: {error}")
        await socket.send_denial_response(problem_response(error))
        return
    carrier = RobotSocket(socket, attachment)
    if request.role == "robot":
        connection.on_round_trip(attachment.place.note_round_trip)
    try:
        await socket.accept(subprotocol=subprotocol_of(socket), headers=attachment.headers)
        await carrier.run()
    finally:
        # A socket that takes over waits for this, and must not wait until a dead socket is closed.
        sessions.detach(attachment, for_good=carrier.left)
    await carrier.close_with_reason()
