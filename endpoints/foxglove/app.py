"""Application for viewers: those that are connected and their limits, the WebSocket, and a page that explains it."""

import asyncio
import logging
from typing import ClassVar

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketState

from endpoints.accounts.authentication import authenticate_socket
from endpoints.audit.requests import AuditedRequests, note_details, note_refusal
from endpoints.foxglove.viewer import Viewer, ViewerLogin, ViewerRequests
from endpoints.http.front import ApplicationFront
from endpoints.http.front_settings import ANY_ORIGIN, FrontSettings, may_open
from endpoints.http.problems import problem_response
from endpoints.http.websocket_protocol import DirectWebSocket, Probe, close_with, connection_of
from endpoints.protocols import ClientProtocol
from endpoints.resources.services import Services
from endpoints.rosbridge import SessionRegistry, content_of
from engine.rights.globs import is_address
from ppaas.errors import InvalidParameter, NotPermitted, PPaaSError, QuotaExceeded
from ppaas.messages import type_name
from ppaas.nodes.topics import TOPICS
from ppaas.wire.foxglove import answers
from ppaas.wire.foxglove.answers import Level
from ppaas.wire.foxglove.conversion.conversions import conversion_of
from ppaas.wire.ros.types import ROS_1, ros_types

logger = logging.getLogger(__name__)

MAX_VIEWERS = 100
"""Largest number of viewers."""

MAX_OF_USER = 16
"""Largest number of viewers of one user."""


class Viewers:
    """Connected viewers.

    Parameters
    ----------
    services : Services
    sessions : SessionRegistry
    """

    def __init__(self, services: Services, sessions: SessionRegistry) -> None:
        self._services = services
        self._sessions = sessions
        self._viewers: set[Viewer] = set()

    def __len__(self) -> int:
        """Return the number of viewers."""
        return len(self._viewers)

    def admit(self, login: ViewerLogin, probe: Probe) -> Viewer:
        """Return a new viewer; `release` must follow.

        Raises
        ------
        QuotaExceeded
            There are too many viewers, or too many of the same user.
        """
        mine = sum(viewer.login.user == login.user for viewer in self._viewers)
        if mine >= MAX_OF_USER or len(self._viewers) >= MAX_VIEWERS:
            raise QuotaExceeded(
                f"at most {MAX_OF_USER} viewers of a user, and {MAX_VIEWERS} in all, are connected: close one first"
            )
        viewer = Viewer(self._services, self._sessions, login, probe)
        self._viewers.add(viewer)
        return viewer

    def release(self, viewer: Viewer) -> None:
        """Close a viewer."""
        self._viewers.discard(viewer)
        viewer.close()

    async def prepare(self) -> None:
        """Read the definitions of types of ROS, which takes a second the first time, in a thread."""
        await asyncio.to_thread(_read_definitions)


def _read_definitions() -> None:
    for topic in TOPICS.values():
        conversion_of(type_name(topic.type))
    ros_types(ROS_1)


# WebSocket of a viewer: ``ws://HOST:PORT/?token=TOKEN``, and optionally ``&robot=ADDRESS`` for some robots only.
#
# A refused viewer gets the reason in a status of the protocol, which Foxglove shows, and is disconnected then. A
# client that offers no subprotocol of Foxglove gets an HTTP problem instead.

# foxglove-sdk offers the first, @foxglove/ws-protocol the second; the messages of both are the same (ADR 0048).
SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""Subprotocols, the preferred one first."""

NAME = "PPaaS"
"""Name of the server in Foxglove."""

MAX_NAMED = 50
"""Largest number of robots that a viewer may name."""

PERIOD = 0.01
"""Time for which a frame waits for others [s]."""

MAX_WAITING = 64 << 10
"""Size of the waiting frames at which they are sent at once [bytes]."""


class BatchingConnection:
    """Connection that sends the frames of a short time at once.

    Many robots send small messages, and each write costs as much as a large one.

    Parameters
    ----------
    connection : DirectWebSocket
    """

    def __init__(self, connection: DirectWebSocket) -> None:
        self._connection = connection
        self._frames: list[bytes] = []
        self._bytes = 0
        self._timer: asyncio.TimerHandle | None = None

    @property
    def ready(self) -> bool:
        """True while frames can be sent."""
        return self._connection.ready

    def send_frame(self, frame: bytes) -> None:
        """Send a frame soon; call it only while ``ready``."""
        self._frames.append(frame)
        self._bytes += len(frame)
        if self._bytes >= MAX_WAITING:
            self.flush()
        elif self._timer is None:
            self._timer = asyncio.get_running_loop().call_later(PERIOD, self.flush)

    def flush(self) -> None:
        """Send what waits, unless the connection is closed."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        frames, self._frames, self._bytes = self._frames, [], 0
        if frames and self._connection.ready:
            self._connection.send_frames(frames)


async def serve_viewer_socket(socket: WebSocket, services: Services, viewers: Viewers) -> None:
    """Serve one WebSocket from its handshake to its end."""
    connection = connection_of(socket)
    connection.name = "unknown viewer of Foxglove"
    note_details(socket.scope, role="operator", protocol="foxglove")
    offered = socket.scope.get("subprotocols", [])
    subprotocol = next((one for one in SUBPROTOCOLS if one in offered), None)
    try:
        if subprotocol is None:
            raise InvalidParameter(f"offer the subprotocol {' or '.join(SUBPROTOCOLS)}: open this address in Foxglove")
        login = await _log_in(socket, services)
        connection.name = f"viewer {login.user} of Foxglove"
        viewer = viewers.admit(login, connection.probe)
    except PPaaSError as error:
        connection.warn(f"refused: {error.slug}: {error}")
        await _refuse(socket, error, subprotocol)
        return
    try:
        await viewers.prepare()
        await socket.accept(subprotocol=subprotocol)
        await _run(socket, viewer)
    finally:
        viewers.release(viewer)
    await _close(socket, viewer)


async def _log_in(socket: WebSocket, services: Services) -> ViewerLogin:
    """Return the login of a viewer; raises as ``authenticate_socket``, or ``InvalidParameter`` for a bad address."""
    _check_page(socket)
    user, token = await authenticate_socket(socket, services.accounts)
    named = tuple(socket.query_params.getlist("robot"))
    if len(named) > MAX_NAMED:
        raise InvalidParameter(f"name at most {MAX_NAMED} robots, or none to see all")
    for address in named:
        if not is_address(address):
            raise InvalidParameter(f"robot must be ID or OWNER:ID, not {address[:64]!r}")
    return ViewerLogin(user.id, token, named)


def _check_page(socket: WebSocket) -> None:
    """Raise ``NotPermitted`` if a page of another host has no token: its browser may send Basic credentials unasked."""
    basic = socket.headers.get("authorization", "").lower().startswith("basic ")
    has_token = socket.query_params.get("token") or socket.query_params.get("ticket")
    if basic and not has_token and not may_open(socket.headers.get("origin", ""), socket.headers.get("host", ""), ()):
        raise NotPermitted("pages of other hosts need a token in the address: add ?token=TOKEN")


async def _run(socket: WebSocket, viewer: Viewer) -> None:
    """Execute requests until the viewer disconnects, or must disconnect."""
    connection = connection_of(socket)
    requests = ViewerRequests(viewer)

    def take(content: bytes, *, binary: bool) -> None:
        try:
            requests.take(content if binary else content.decode())
        except Exception as error:
            logger.exception("%s: a request failed", connection.name)
            viewer.end(PPaaSError(f"internal error: {type(error).__name__}"))

    async def until_left() -> None:
        while (message := await socket.receive())["type"] != "websocket.disconnect":
            content, binary = content_of(message)
            take(content, binary=binary)  # received before the handshake was answered

    viewer.answer(answers.server_info(NAME, viewer.session_id))
    connection.hand_to(take, viewer.flush)
    sink = BatchingConnection(connection)
    viewer.outbox.connect(sink)
    tasks = asyncio.create_task(until_left()), asyncio.create_task(requests.run())
    try:
        await asyncio.wait((*tasks, viewer.over), return_when=asyncio.FIRST_COMPLETED)
    finally:
        viewer.outbox.connect(None)
        sink.flush()
        connection.hand_to(None)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def _close(socket: WebSocket, viewer: Viewer) -> None:
    """Close the socket with the reason, unless the viewer closed it."""
    if viewer.over.done() and socket.application_state is WebSocketState.CONNECTED:
        await _show_and_close(socket, viewer.over.result())


async def _refuse(socket: WebSocket, error: PPaaSError, subprotocol: str | None) -> None:
    response = problem_response(error)
    if subprotocol is None:
        await socket.send_denial_response(response)
        return
    note_refusal(socket.scope, response.status_code)
    await socket.accept(subprotocol=subprotocol)
    await _show_and_close(socket, error)


async def _show_and_close(socket: WebSocket, error: PPaaSError) -> None:
    """Close the socket with the reason, after a status with it, which Foxglove shows."""
    # Browsers and Foxglove show no answer of HTTP to a handshake, so the reason goes by the protocol (ADR 0048).
    await close_with(socket, error, last=answers.status(Level.ERROR, f"{error.slug}: {error.public}"))


MAX_FRAME = 1024 * 1024
"""Largest frame of a viewer [bytes], which publishes goals, not sensors."""


class Foxglove(ClientProtocol):
    """Foxglove's WebSocket protocol; needs the extra ``foxglove``."""

    max_frame: ClassVar[int] = MAX_FRAME

    def app(self) -> ASGIApp:
        """Return the application."""
        return foxglove_app(self._services, self._sessions, self._settings)


def foxglove_app(services: Services, sessions: SessionRegistry, settings: FrontSettings) -> ASGIApp:
    """Return the application; its address is ``/``.

    Parameters
    ----------
    services : Services
        Services with the accounts, the store and the audit log.
    sessions : SessionRegistry
        Attaches to the places of robots.
    settings : FrontSettings
        Trusted proxies.
    """
    viewers = Viewers(services, sessions)

    async def viewer_socket(websocket: WebSocket) -> None:
        await serve_viewer_socket(websocket, services, viewers)

    app = Starlette(
        routes=[Route("/", _page, methods=["GET"]), WebSocketRoute("/", viewer_socket)],
        middleware=[Middleware(AuditedRequests, log=services.audit)],
    )
    # Foxglove's own pages are of other hosts, and send no cookies: the token in the address is the right to connect.
    return ApplicationFront(app, settings, private="/v1", origins=(ANY_ORIGIN,))


async def _page(request: Request) -> Response:
    scheme = "wss" if request.url.scheme == "https" else "ws"
    address = f"{scheme}://{request.url.netloc}/?token=TOKEN"
    return PlainTextResponse(f"Open a connection in Foxglove: Foxglove WebSocket, {address}\n")
