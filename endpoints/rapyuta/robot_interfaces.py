"""Interfaces on robots: converters and forwarders, which exchange messages with the robot by DM."""

from collections.abc import Callable
from typing import Any
from uuid import uuid4

from endpoints.clients.place_client import MAX_WAITING
from endpoints.rapyuta.interfaces import Answerer, Asker, Interface, Sink, Source
from engine.links.open_calls import Done, OpenCalls, Outcome
from engine.sessions.calls import CALL_TIMEOUT
from ppaas.errors import InvalidInput, PPaaSError, QuotaExceeded, Unavailable
from ppaas.wire.rapyuta.answers import Frames, data_message, error_message, interface_status
from ppaas.wire.rapyuta.interface_types import InterfaceRole, InterfaceType
from ppaas.wire.rapyuta.message_codec import codecs_of
from ppaas.wire.rapyuta.requests import DataMessage

Send = Callable[[Frames, str | None], None]
"""Called with frames for the robot, and the topic of which they are a message; None if they must not be dropped."""


class RobotInterface(Interface):
    """Interface on a robot.

    Parameters
    ----------
    robot, tag, kind, class_name
        See `Interface`.
    send : callable
        Sends frames to the robot.

    Raises
    ------
    InvalidInput
        The type belongs to an interface in a container, or the class is not known to a forwarder.
    """

    def __init__(self, robot: str, tag: str, kind: InterfaceType, class_name: str, send: Send) -> None:
        super().__init__(robot, tag, kind, class_name)
        self._send = send
        self._reads, self._writes = codecs_of(kind, class_name)
        self._active = False

    def peers_changed(self) -> None:
        """Notify the robot that the interface was connected or disconnected."""
        if self._active is not bool(self.peers):
            self._active = bool(self.peers)
            self._send(interface_status(self.tag, active=self._active), None)

    def take(self, message: DataMessage) -> None:
        """Take a message of the robot.

        Raises
        ------
        InvalidInput
            Its class is not the interface's, or it is not a message of this class.
        """
        if message.type != self.class_name:
            raise InvalidInput(
                f"Sent message type does not match the used message type for this interface: {self.tag!r} has "
                f"{self.class_name}, not {message.type[:64]!r}"
            )
        self._taken(message.msg, message.msgID)

    def _taken(self, message: Any, message_id: str) -> None:
        raise InvalidInput(f"This converter can not handle incoming messages: {self.tag!r} is a {self.kind}")

    def _put(self, payload: bytes, message_id: str, topic: str | None = None) -> None:
        frames = data_message(self.tag, self.class_name, message_id, self._writes.write(payload))
        self._send(frames, topic)


class RobotSubscriber(RobotInterface, Source):
    """Subscriber on a robot: the robot sends messages."""

    def _taken(self, message: Any, message_id: str) -> None:
        self.forward(self._reads.read(message), self.tag)


class RobotPublisher(RobotInterface, Sink):
    """Publisher on a robot: the robot receives messages."""

    def deliver(self, payload: bytes, topic: str) -> None:
        """Send a message to the robot."""
        self._put(payload, uuid4().hex, topic)


class RobotServiceProvider(RobotInterface, Asker):
    """Provider of a service on a robot: the robot sends requests, and receives responses with the same id."""

    def _taken(self, message: Any, message_id: str) -> None:
        def done(outcome: Outcome) -> None:
            try:
                if isinstance(outcome, PPaaSError):
                    raise outcome
                self._put(outcome, message_id)
            except PPaaSError as error:
                text = f"request {message_id!r} of interface {self.tag!r} failed: {error.public}"
                self._send(error_message(Unavailable(text)), None)

        self.ask(self._reads.read(message), done)


class RobotServiceClient(RobotInterface, Answerer):
    """Client of a service on a robot: the robot receives requests, and sends responses with the same id."""

    def __init__(self, robot: str, tag: str, kind: InterfaceType, class_name: str, send: Send) -> None:
        super().__init__(robot, tag, kind, class_name, send)
        self._calls = OpenCalls()
        self._requests: dict[str, int] = {}

    def request(self, payload: bytes, done: Done) -> None:
        """Send a request to the robot.

        Raises
        ------
        QuotaExceeded
            The robot has not answered too many requests.
        """
        if len(self._requests) >= MAX_WAITING:
            raise QuotaExceeded(f"{MAX_WAITING} requests of interface {self.address!r} wait for the robot: try later")
        message_id = uuid4().hex

        def ended(outcome: Outcome) -> None:
            del self._requests[message_id]
            done(outcome)

        self._put(payload, message_id)
        self._requests[message_id] = self._calls.open(self.address, CALL_TIMEOUT, ended)

    def _taken(self, message: Any, message_id: str) -> None:
        number = self._requests.get(message_id)
        if number is None:
            raise InvalidInput(f"Service Client does not wait for a response with message ID {message_id[:64]!r}.")
        try:
            outcome: Outcome = self._reads.read(message)
        except PPaaSError as error:
            self._calls.end(number, error)
            raise
        self._calls.end(number, outcome)

    def close(self) -> None:
        """Fail the requests that the robot has not answered."""
        self._calls.fail(Unavailable(f"the interface {self.address!r} was removed before it answered"))


ROBOT_INTERFACES: dict[InterfaceRole, type[RobotInterface]] = {
    InterfaceRole.SUBSCRIBER: RobotSubscriber,
    InterfaceRole.PUBLISHER: RobotPublisher,
    InterfaceRole.SERVICE_PROVIDER: RobotServiceProvider,
    InterfaceRole.SERVICE_CLIENT: RobotServiceClient,
}
