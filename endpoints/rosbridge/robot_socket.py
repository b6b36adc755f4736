"""Robot WebSocket: ``ws://HOST/?robot=ID&role=robot|operator&session=NAME``, speaking rosbridge v2.

A client whose user has one robot need not name it.

A connection is refused before the handshake is complete, with an HTTP problem.
"""

import asyncio
import logging
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from starlette.websockets import WebSocket, WebSocketState

from endpoints.accounts.authentication import authenticate_socket, subprotocol_of
from endpoints.audit.notes import note_object
from endpoints.http.closing import close_with
from endpoints.http.problems import problem_response
from endpoints.http.websocket_protocol import connection_of
from endpoints.rosbridge.admission import admitted
from endpoints.rosbridge.attachment import Attachment, Caller
from endpoints.rosbridge.connect_request import parse_connect_request
from endpoints.rosbridge.only_robot import only_robot
from endpoints.rosbridge.session_registry import SessionRegistry
from endpoints.services.services import Services
from ppaas.errors import PPaaSError
from ppaas.wire.resumption import LEFT

logger = logging.getLogger(__name__)

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
        request = replace(request, png=reads_png(socket.headers.get("user-agent", "")))
        connection.name = request.client(user.id).title
        await services.cloud.set_limits(user.id, user.limits)
        request, access = await admitted(services, user, request)
        with services.refused_connects.attempt(request.owner or user.id, request.robot, request.role):
            attachment = await sessions.attach(Caller(user.id, token, connection.probe), request, access)
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
