"""Application for robots of Rapyuta: the master's page with the address, and the WebSocket.

The socket is opened at ``ws://HOST:PORT/?userID=U&robotID=R&password=HASH``.
"""

import asyncio
import logging

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketState

from endpoints.audit.requests import AuditedRequests
from endpoints.http.front import ApplicationFront
from endpoints.http.front_settings import FrontSettings
from endpoints.http.websocket_protocol import close_with, connection_of
from endpoints.protocols import ClientProtocol
from endpoints.rapyuta.executor import Executor
from endpoints.rapyuta.registry import RobotRegistry, log_in
from endpoints.rapyuta.robot import RapyutaRobot, RobotConnection
from endpoints.resources.services import Services
from endpoints.rosbridge import SessionRegistry
from ppaas.errors import (
    Conflict,
    InvalidInput,
    NotAuthenticated,
    NotPermitted,
    PPaaSError,
    TooManyAttempts,
    Unavailable,
)
from ppaas.wire.rapyuta.handshake import answer_master, parse_login
from ppaas.wire.rapyuta.part_assembler import PartAssembler

logger = logging.getLogger(__name__)

CONNECT_TIMEOUT = 30.0
"""Time limit from the login of a robot to its open connection [s], as in rce."""

FATAL = "Fatal Error"
"""Text of errors that are faults of the cloud, as in rce."""


class RapyutaSocket:
    """One connection of a robot.

    Parameters
    ----------
    socket : WebSocket
        Accepted WebSocket.
    robot : RapyutaRobot
    carrier : RobotConnection
        Sends its frames.
    executor : Executor
        Executes its requests.
    """

    def __init__(self, socket: WebSocket, robot: RapyutaRobot, carrier: RobotConnection, executor: Executor) -> None:
        self._socket = socket
        self._robot = robot
        self._carrier = carrier
        self._executor = executor
        self._parts = PartAssembler()

    async def run(self) -> None:
        """Execute requests until the robot disconnects, must disconnect, or another connection replaces this one."""
        connection = connection_of(self._socket)
        connection.hand_to(None, self._robot.outbox.flush)
        connection.on_round_trip(self._note_round_trip)
        self._robot.outbox.connect(self._carrier)
        reading = asyncio.create_task(self._read())
        try:
            ends = (reading, self._robot.over, self._carrier.displaced)
            await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
        finally:
            connection.hand_to(None)
            reading.cancel()
            await asyncio.gather(reading, return_exceptions=True)

    async def _read(self) -> None:
        while (message := await self._socket.receive())["type"] != "websocket.disconnect":
            try:
                await self._take(message.get("text"), message.get("bytes"))
            except PPaaSError as error:
                self._robot.report(error)
            except Exception:
                logger.exception("robot %s/%s: a request failed", self._robot.identity.user, self._robot.tag)
                self._robot.report(PPaaSError(FATAL))

    async def _take(self, text: str | None, data: bytes | None) -> None:
        message = self._parts.take_text(text) if text is not None else self._parts.take_binary(data or b"")
        if message is not None:
            await self._executor.execute(message)

    def _note_round_trip(self, seconds: float) -> None:
        if self._robot.clone is not None:
            self._robot.clone.note_round_trip(seconds)

    async def close_with_reason(self) -> None:
        """Close the socket with the reason, unless the robot closed it."""
        if self._socket.application_state is not WebSocketState.CONNECTED:
            return
        if self._carrier.displaced.done():
            await close_with(self._socket, self._carrier.displaced.result())
        elif self._robot.over.done():
            await close_with(self._socket, self._robot.over.result())


async def serve_robot_socket(socket: WebSocket, services: Services, registry: RobotRegistry) -> None:
    """Serve one WebSocket from its handshake to its end."""
    connection = connection_of(socket)
    connection.name = "unknown robot of Rapyuta"
    carrier = RobotConnection(connection)
    try:
        async with asyncio.timeout(CONNECT_TIMEOUT):
            login = parse_login(socket.query_params.multi_items())
            user, identity = await log_in(socket, login, services)
            connection.name = f"robot {user.id}/{login.robot[:64]} of Rapyuta"
            await services.cloud.set_limits(user.id, user.limits)
            robot, executor = await registry.attach(login.robot, identity, carrier)
    except (PPaaSError, TimeoutError) as error:
        connection.warn(f"refused: {error}")
        await socket.send_denial_response(refusal(error))
        return
    served = RapyutaSocket(socket, robot, carrier, executor)
    try:
        await socket.accept()
        await served.run()
    finally:
        registry.detach(robot, carrier)
    await served.close_with_reason()


def refusal(error: Exception) -> Response:
    """Return the answer to a handshake that is refused: 400, 401 or 500 with a text, as robots of 2013 expect."""
    if isinstance(error, NotAuthenticated | TooManyAttempts | NotPermitted):
        retry = getattr(error, "retry_after", None)
        headers = {"WWW-Authenticate": "Rapyuta"} | ({} if retry is None else {"Retry-After": f"{retry:.0f}"})
        return PlainTextResponse(str(error), 401, headers)
    if isinstance(error, InvalidInput | Conflict):
        return PlainTextResponse(error.public, 400)
    return PlainTextResponse(error.public if isinstance(error, Unavailable) else FATAL, 500)


class Rapyuta(ClientProtocol):
    """Protocol of 2013."""

    def __init__(self, services: Services, sessions: SessionRegistry, settings: FrontSettings) -> None:
        super().__init__(services, sessions, settings)
        self._registry = RobotRegistry(services, sessions)

    def app(self) -> ASGIApp:
        """Return the application."""
        return rapyuta_app(self._services, self._registry, self._settings)

    async def watch(self) -> None:
        """Check periodically whether robots may still be logged in."""
        await self._registry.watch()

    async def close(self) -> None:
        """End all robots."""
        await self._registry.close()


def rapyuta_app(services: Services, registry: RobotRegistry, settings: FrontSettings) -> ASGIApp:
    """Return the application; its address is ``/`` for both.

    Parameters
    ----------
    services : Services
        Services with the accounts, the store and the audit log.
    registry : RobotRegistry
        Registry of the robots.
    settings : FrontSettings
        Trusted proxies, which may state the address by which robots come.
    """

    async def robot_socket(websocket: WebSocket) -> None:
        await serve_robot_socket(websocket, services, registry)

    app = Starlette(
        routes=[Route("/", _master, methods=["GET"]), WebSocketRoute("/", robot_socket)],
        middleware=[Middleware(AuditedRequests, log=services.audit)],
        exception_handlers={Exception: _fault},
    )
    return ApplicationFront(app, settings, private="/v1")


async def _master(request: Request) -> Response:
    """Return the address of the WebSocket: the address of this request, which the robot has reached."""
    scheme = "wss" if request.url.scheme == "https" else "ws"
    answer = answer_master(request.query_params.multi_items(), f"{scheme}://{request.url.netloc}/")
    return Response(answer.body, answer.status, {"Cache-Control": "no-store"}, answer.media_type)


async def _fault(_request: Request, _error: Exception) -> Response:
    return PlainTextResponse(FATAL, 500)
