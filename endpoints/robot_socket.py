"""The robot WebSocket: ``ws://HOST/?robot=ID&token=T&role=robot|operator``, speaking rosbridge v2.

A refusal comes before the handshake is done, as an HTTP problem. After it, what a client does wrong is told to that
client alone, and only if it asked for ``status`` (by ``set_level`` or ``&status=1``).
"""

import asyncio
import contextlib
import logging
from typing import assert_never

from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from endpoints.auth import authenticate
from endpoints.outbox import DEFAULT_KEEP, KEEP, Outbox
from endpoints.problems import problem_response
from endpoints.rights import Role, check_may_publish, must_arrive, role_of
from endpoints.services import Services
from engine.place_link import PlaceLink
from engine.robot_sessions import RobotSessions
from ppaas.clock import monotonic
from ppaas.errors import InvalidParameter, MalformedMessage, PPaaSError, QuotaExceeded
from ppaas.messages import message_type
from ppaas.wire import rosbridge
from ppaas.wire.names import normalise

logger = logging.getLogger(__name__)

READY_TIMEOUT = 15.0
CALL_TIMEOUT = 60.0
MAX_CALLS = 32
"""Calls of one client that may be under way at a time."""

CLOSED_BY_CLOUD = 1011
CLOSE_TIMEOUT = 2.0
MAX_REASON = 123
"""Bytes of reason that a close frame holds."""

MAX_LOGGED = 64
"""Kinds of faults of one client that are told in the log; clients may think out topics without end."""


class RobotSocket:
    """One client of one place.

    Parameters
    ----------
    socket : WebSocket
        Accepted.
    place : PlaceLink
        Of the robot.
    role : {"robot", "operator"}
        What it may publish.
    session : RosbridgeSession
        What was said so far.
    name : str
        For the log.
    """

    def __init__(
        self, socket: WebSocket, place: PlaceLink, role: Role, session: rosbridge.RosbridgeSession, name: str
    ) -> None:
        self._socket = socket
        self._place = place
        self._role = role
        self._session = session
        self._name = name
        self._outbox = Outbox()
        self._calls: set[asyncio.Task[None]] = set()
        self._logged: set[tuple[str, str]] = set()
        self._over: asyncio.Future[PPaaSError] = asyncio.get_running_loop().create_future()
        self._client = place.join(self)

    async def run(self) -> None:
        """Serve the client until it, or the place, goes."""
        reader, writer = asyncio.create_task(self._read()), asyncio.create_task(self._write())
        for task in (reader, writer):
            task.add_done_callback(self._ended)
        try:
            await asyncio.wait((reader, writer, self._over), return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._place.leave(self._client)
            tasks = (reader, writer, *self._calls)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await self._say_why()

    def _ended(self, task: asyncio.Task[None]) -> None:
        error = None if task.cancelled() else task.exception()
        if error is not None and not isinstance(error, WebSocketDisconnect):
            logger.error("%s: serving failed", self._name, exc_info=error)
            self.closed(PPaaSError(f"internal error: {type(error).__name__}"))

    async def _say_why(self) -> None:
        """Close the socket with the reason, if it was not the client that went."""
        if not self._over.done() or self._socket.application_state is not WebSocketState.CONNECTED:
            return
        error = self._over.result()
        reason = f"{error.slug}: {error}".encode()[:MAX_REASON].decode(errors="ignore")
        with contextlib.suppress(TimeoutError, WebSocketDisconnect):
            async with asyncio.timeout(CLOSE_TIMEOUT):
                await self._socket.close(CLOSED_BY_CLOUD, reason)

    # -- from the client -----------------------------------------------------------------------------------------------

    async def _read(self) -> None:
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            try:
                self._take(message.get("text"))
            except PPaaSError as error:
                self._tell(error)

    def _take(self, frame: str | None) -> None:
        if frame is None:
            raise MalformedMessage("binary frames are not understood: send JSON as text")
        operation = self._session.receive(frame)
        match operation:
            case rosbridge.Publish():
                topic = normalise(operation.topic)
                check_may_publish(self._role, topic)
                self._place.deliver(topic, bytes(operation.msg), self._client, must_arrive=must_arrive(topic))
            case rosbridge.Subscribe():
                self._subscribe(normalise(operation.topic))
            case rosbridge.Unsubscribe():
                topic = normalise(operation.topic)
                if topic not in self._session.subscribed():
                    self._place.unsubscribe(topic, self._client)
            case rosbridge.Advertise():
                check_may_publish(self._role, normalise(operation.topic))
                message_type(operation.type)
            case rosbridge.Unadvertise() | rosbridge.SetLevel():
                pass
            case rosbridge.CallService():
                self._start_call(operation)
            case _:
                assert_never(operation)

    def _subscribe(self, topic: str) -> None:
        try:
            self._place.subscribe(topic, self._client)
        except PPaaSError:
            self._session.forget(topic)
            raise

    def _start_call(self, operation: rosbridge.CallService) -> None:
        if len(self._calls) >= MAX_CALLS:
            error = QuotaExceeded(f"a client may have {MAX_CALLS} calls under way")
            self._answer(self._session.refuse_call(operation, error))
            return
        task = asyncio.create_task(self._call(operation))
        self._calls.add(task)
        task.add_done_callback(self._calls.discard)

    async def _call(self, operation: rosbridge.CallService) -> None:
        try:
            service = normalise(operation.service)
            values = await self._place.call(service, bytes(operation.args), CALL_TIMEOUT)
            frame = self._session.answer(operation, values)
        except PPaaSError as error:
            frame = self._session.refuse_call(operation, error)
        self._answer(frame)

    def _answer(self, frame: str) -> None:
        try:
            self._outbox.put_answer(frame)
        except PPaaSError as error:  # an answer is not dropped; rather the client is
            self.closed(error)

    def _tell(self, error: PPaaSError, about: str = "") -> None:
        first = (error.slug, about) not in self._logged and len(self._logged) < MAX_LOGGED
        if first:
            self._logged.add((error.slug, about))
        logger.log(logging.WARNING if first else logging.DEBUG, "%s: %s: %s", self._name, error.slug, error)
        status = self._session.status(error)
        if status is not None:
            self._outbox.put("", status, DEFAULT_KEEP)

    # -- to the client -------------------------------------------------------------------------------------------------

    async def _write(self) -> None:
        while True:
            await self._socket.send_text(await self._outbox.get())

    def published(self, topic: str, payload: bytes) -> None:
        """Take a message of a topic that the client subscribed to."""
        keep = self._session.queue_length(topic, KEEP.get(topic, DEFAULT_KEEP))
        for frame in self._session.publish(topic, payload, monotonic()):
            self._outbox.put(topic, frame, keep)

    def refused(self, topic: str, error: PPaaSError) -> None:
        """Learn that the clone did not take a message of this client."""
        self._tell(error, topic)

    def closed(self, reason: PPaaSError) -> None:
        """Learn that the place is no more, or no more for this client."""
        if not self._over.done():
            self._over.set_result(reason)


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
    await RobotSocket(socket, place, role, rosbridge.RosbridgeSession(level), name).run()
