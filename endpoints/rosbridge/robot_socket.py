"""The robot WebSocket: ``ws://HOST/?robot=ID&token=T&role=robot|operator&session=NAME``, speaking rosbridge v2.

A refusal comes before the handshake is done, as an HTTP problem.
"""

import asyncio
import contextlib
import logging

from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from endpoints.accounts.authentication import authenticate
from endpoints.http.problems import problem_response
from endpoints.http.websocket_protocol import connection_of
from endpoints.rosbridge.attachment import Attachment
from endpoints.rosbridge.connect_request import parse_connect_request
from endpoints.rosbridge.session_registry import SessionRegistry
from endpoints.services.services import Services
from ppaas.errors import PPaaSError
from ppaas.wire.resumption import LEFT

logger = logging.getLogger(__name__)

CLOSED_BY_CLOUD = 1011
TAKEN_OVER = 4409
CLOSE_TIMEOUT = 2.0
MAX_REASON = 123
"""Bytes of reason that a close frame holds."""


class RobotSocket:
    """One connection of a client.

    Parameters
    ----------
    socket : WebSocket
        Accepted.
    attachment : Attachment
        To the session whose frames it carries.

    Attributes
    ----------
    left : bool
        The client said, in closing, that it does not come back.
    """

    def __init__(self, socket: WebSocket, attachment: Attachment) -> None:
        self._socket = socket
        self._connection = connection_of(socket)
        self._attachment = attachment
        self._session = attachment.session
        self.left = False

    async def run(self) -> None:
        """Carry frames until the client goes, or its place, or its session is given to another socket."""
        outbox = self._session.outbox
        self._connection.hand_to(self._take, outbox.flush)
        outbox.connect(self._connection)
        left = asyncio.create_task(self._until_left())
        try:
            ends = (left, self._session.over, self._attachment.displaced)
            await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
        finally:
            outbox.connect(None)
            self._connection.hand_to(None)
            left.cancel()
            await asyncio.gather(left, return_exceptions=True)

    def _take(self, frame: str | None) -> None:
        self._attachment.retained.taken += 1
        try:
            self._session.take(frame)
        except Exception as error:
            logger.exception("%s: serving failed", self._session.name)
            self._session.closed(PPaaSError(f"internal error: {type(error).__name__}"))

    async def _until_left(self) -> None:
        while (message := await self._socket.receive())["type"] != "websocket.disconnect":
            self._take(message.get("text"))  # it came before its handshake was answered
        self.left = message.get("reason") == LEFT

    async def say_why(self) -> None:
        """Close the socket with the reason, if it was not the client that went."""
        if self._socket.application_state is not WebSocketState.CONNECTED:
            return
        if self._attachment.displaced.done():
            await self._close(TAKEN_OVER, self._attachment.displaced.result())
        elif self._session.over.done():
            await self._close(CLOSED_BY_CLOUD, self._session.over.result())

    async def _close(self, code: int, error: PPaaSError) -> None:
        reason = f"{error.slug}: {error}".encode()[:MAX_REASON].decode(errors="ignore")
        with contextlib.suppress(TimeoutError, WebSocketDisconnect):
            async with asyncio.timeout(CLOSE_TIMEOUT):
                await self._socket.close(code, reason)


async def serve_robot_socket(socket: WebSocket, services: Services, sessions: SessionRegistry) -> None:
    """Serve one WebSocket from its handshake to its end."""
    try:
        request = parse_connect_request(socket.query_params)
        user = await authenticate(socket, services.accounts)
        services.cloud.quotas.learn(user)
        attachment = await sessions.attach(user.id, request, connection_of(socket).probe)
    except PPaaSError as error:
        logger.warning("a WebSocket was refused: %s: %s", error.slug, error)
        await socket.send_denial_response(problem_response(error))
        return
    carrier = RobotSocket(socket, attachment)
    if request.role == "robot":
        connection_of(socket).tell_round_trips(attachment.retained.place.note_round_trip)
    try:
        await socket.accept(headers=attachment.headers)
        await carrier.run()
    finally:
        # Whoever takes over waits for this, and must not wait for a socket that is dead to be closed.
        sessions.detach(attachment, for_good=carrier.left)
    await carrier.say_why()
