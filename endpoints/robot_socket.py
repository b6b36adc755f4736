"""The robot WebSocket: ``ws://HOST/?robot=ID&token=T&role=robot|operator``, speaking rosbridge v2.

A refusal comes before the handshake is done, as an HTTP problem.
"""

import asyncio
import contextlib
import logging

from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from endpoints.auth import authenticate
from endpoints.client_session import ClientSession
from endpoints.problems import problem_response
from endpoints.rights import Role, role_of
from endpoints.services import Services
from engine.place_link import PlaceLink
from engine.robot_sessions import RobotSessions
from ppaas.errors import InvalidParameter, PPaaSError
from ppaas.wire import rosbridge

logger = logging.getLogger(__name__)

READY_TIMEOUT = 15.0
CLOSED_BY_CLOUD = 1011
CLOSE_TIMEOUT = 2.0
MAX_REASON = 123
"""Bytes of reason that a close frame holds."""


class RobotSocket:
    """One connection of a client.

    Parameters
    ----------
    socket : WebSocket
        Accepted.
    session : ClientSession
        Whom it carries.
    """

    def __init__(self, socket: WebSocket, session: ClientSession) -> None:
        self._socket = socket
        self._session = session

    async def run(self) -> None:
        """Carry frames until the client, or its place, goes."""
        tasks = reader, writer = asyncio.create_task(self._read()), asyncio.create_task(self._write())
        for task in tasks:
            task.add_done_callback(self._ended)
        try:
            await asyncio.wait((reader, writer, self._session.over), return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await self._say_why()

    def _ended(self, task: asyncio.Task[None]) -> None:
        error = None if task.cancelled() else task.exception()
        if error is not None and not isinstance(error, WebSocketDisconnect):
            logger.error("%s: serving failed", self._session.name, exc_info=error)
            self._session.closed(PPaaSError(f"internal error: {type(error).__name__}"))

    async def _say_why(self) -> None:
        """Close the socket with the reason, if it was not the client that went."""
        if not self._session.over.done() or self._socket.application_state is not WebSocketState.CONNECTED:
            return
        error = self._session.over.result()
        reason = f"{error.slug}: {error}".encode()[:MAX_REASON].decode(errors="ignore")
        with contextlib.suppress(TimeoutError, WebSocketDisconnect):
            async with asyncio.timeout(CLOSE_TIMEOUT):
                await self._socket.close(CLOSED_BY_CLOUD, reason)

    async def _read(self) -> None:
        while (message := await self._socket.receive())["type"] != "websocket.disconnect":
            self._session.take(message.get("text"))

    async def _write(self) -> None:
        while True:
            await self._socket.send_text(await self._session.outbox.get())


async def serve_robot_socket(socket: WebSocket, services: Services, sessions: RobotSessions) -> None:
    """Serve one WebSocket from its handshake to its end."""
    try:
        role = role_of(socket.query_params.get("role", "robot"))
        robot = socket.query_params.get("robot", "")
        if not robot:
            raise InvalidParameter("no robot named: open ws://HOST/?robot=ID&token=TOKEN")
        user = await authenticate(socket, services.accounts)
        place = await sessions.join(user.id, robot, as_robot=role == "robot")
    except PPaaSError as error:
        logger.warning("a WebSocket was refused: %s: %s", error.slug, error)
        await socket.send_denial_response(problem_response(error))
        return
    try:
        await _serve(socket, place, role, f"{role} {user.id}/{robot}")
    finally:
        sessions.leave(place, as_robot=role == "robot")


async def _serve(socket: WebSocket, place: PlaceLink, role: Role, name: str) -> None:
    try:
        await place.ready(READY_TIMEOUT)
    except PPaaSError as error:
        logger.warning("%s was refused: %s: %s", name, error.slug, error)
        await socket.send_denial_response(problem_response(error))
        return
    await socket.accept()
    level: rosbridge.Level = "error" if socket.query_params.get("status") == "1" else "none"
    session = ClientSession(place, role, rosbridge.RosbridgeSession(level), name)
    try:
        await RobotSocket(socket, session).run()
    finally:
        await session.end()
