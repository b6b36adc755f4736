"""Robot as an endpoint: its interfaces, its containers, and the frames that wait for it."""

import asyncio
from dataclasses import dataclass

from endpoints.http.websocket_protocol import DirectWebSocket
from endpoints.rapyuta.clone import RapyutaContainer, SharedClone
from endpoints.rapyuta.interfaces import ROBOT_INTERFACES, RapyutaEndpoint, RobotInterface
from engine.sessions.outbox import FrameOutbox
from ppaas.errors import InvalidInput, PPaaSError
from ppaas.nodes.topics import policy_of
from ppaas.wire.binary.binary_frame import BinaryFrame
from ppaas.wire.rapyuta.answers import AnswerFrames, error_message
from ppaas.wire.rapyuta.interface_types import InterfaceForm, interface_type
from ppaas.wire.rapyuta.requests import AddInterface, DataMessage
from ppaas.wire.rapyuta.tags import check_tag

ERRORS = ""
"""Name in the outbox under which errors wait."""

MAX_ERRORS = 100
"""Largest number of errors that wait; beyond it, the oldest is dropped."""


@dataclass(frozen=True, slots=True)
class Identity:
    """Login of a robot: its user, the id of the token, and the verifier of its password; empty for a token."""

    user: str
    token: str
    verifier: str = ""


class RobotConnection:
    """Connection that the frames of a robot are sent by.

    Parameters
    ----------
    connection : DirectWebSocket
        Connection.
    """

    def __init__(self, connection: DirectWebSocket) -> None:
        self._connection = connection
        self.displaced: asyncio.Future[PPaaSError] = asyncio.get_running_loop().create_future()
        self.left = asyncio.Event()

    @property
    def ready(self) -> bool:
        """True while frames can be sent."""
        return self._connection.ready

    def send_frame(self, frame: bytes) -> None:
        """Send a text frame and its binary frames; only while ready."""
        frames = AnswerFrames.unpack(frame)
        self._connection.send_frame(frames.text)
        for part in frames.parts:
            self._connection.send_frame(BinaryFrame(part))

    async def answers(self, timeout: float) -> bool:
        """Return whether the robot answers a ping within a time [s]."""
        return await self._connection.probe(timeout)

    async def displace(self, why: PPaaSError) -> None:
        """Close the connection in favour of another one, and wait until it is no longer used."""
        if not self.displaced.done():
            self.displaced.set_result(why)
        await self.left.wait()


class RapyutaRobot(RapyutaEndpoint):
    """Robot of 2013, connected or away for a moment.

    Parameters
    ----------
    tag : str
        Robot ID.
    identity : Identity
        Login.

    Attributes
    ----------
    over : Future
        Done once the robot must disconnect; its result is the reason.
    containers : dict of str to RapyutaContainer
        Containers that it created, by tag.
    clone : SharedClone or None
        Its clone, while it has containers.
    """

    def __init__(self, tag: str, identity: Identity) -> None:
        super().__init__(tag)
        self.identity = identity
        self.over: asyncio.Future[PPaaSError] = asyncio.get_running_loop().create_future()
        self.outbox = FrameOutbox()
        self.containers: dict[str, RapyutaContainer] = {}
        self.clone: SharedClone | None = None
        self.carrier: RobotConnection | None = None
        self.expiry: asyncio.TimerHandle | None = None

    def renew(self, identity: Identity) -> None:
        """Replace the robot's login by another token of the same user."""
        self.identity = identity
        if self.clone is not None:
            self.clone.renew_token(identity.token)

    async def answers(self, timeout: float) -> bool:
        """Return whether the robot is connected and answers a ping within a time [s]."""
        return self.carrier is not None and await self.carrier.answers(timeout)

    # -- frames --------------------------------------------------------------------------------------------------------

    def disconnect(self) -> None:
        """Hold frames for the next connection."""
        self.carrier = None
        self.outbox.connect(None)

    def send(self, frames: AnswerFrames, topic: str | None) -> None:
        """Send frames: a message of a topic, of which old ones may be dropped; with None, what must arrive."""
        try:
            if topic is None:
                self.outbox.put_answer(frames.packed())
            else:
                self.outbox.put(topic, frames.packed(), policy_of(topic).depth)
        except PPaaSError as error:
            self.end(error)

    def report(self, error: PPaaSError) -> None:
        """Send an error."""
        self.outbox.put(ERRORS, error_message(error).packed(), MAX_ERRORS)

    def end(self, reason: PPaaSError) -> None:
        """Make the robot disconnect."""
        if not self.over.done():
            self.over.set_result(reason)

    # -- interfaces ----------------------------------------------------------------------------------------------------

    def add_interface(self, wanted: AddInterface) -> None:
        """Add an interface.

        Raises
        ------
        InvalidInput
            Its type is one of containers, or a forwarder does not know the class.
        PPaaSError
            The tag is taken or invalid.
        """
        kind = interface_type(wanted.interfaceType)
        if kind.form is InterfaceForm.INTERFACE:
            raise InvalidInput(
                f"{kind} is a type of interfaces in containers, and {self.tag!r} is a robot: use {kind.role}Converter"
            )
        tag = check_tag("interfaceTag", wanted.interfaceTag)
        self.check_free(tag)
        self.interfaces[tag] = ROBOT_INTERFACES[kind.role](self.tag, tag, kind, wanted.className, self.send)

    def take(self, message: DataMessage) -> None:
        """Take a message for one of the interfaces; raises if there is no such interface, or it is not one for it."""
        interface = self.interface(message.iTag)
        assert isinstance(interface, RobotInterface)
        interface.take(message)
