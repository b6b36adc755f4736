"""Messages of interfaces on robots: what a robot sends and receives in a DM, and the JSON that the clone uses.

A converter has JSON, with times as ``YYYY-MM-DDTHH:MM:SS.mmmmmm`` (UTC) and durations as seconds; a forwarder has the
bytes of ROS 1, compressed by zlib.

Source: ``rce/util/converter.py`` and ``rce/monitor/interface/robot.py``.
"""

from typing import Any, Protocol

from ppaas.errors import InvalidInput, UnknownType
from ppaas.messages.base.message import Message
from ppaas.messages.registry import message_type, service_type
from ppaas.wire.names import ros1_type
from ppaas.wire.rapyuta.converter import Converter
from ppaas.wire.rapyuta.forwarder import Forwarder
from ppaas.wire.rapyuta.interface_types import InterfaceForm, InterfaceRole, InterfaceType

CLASSES = {"tf/tfMessage": "tf2_msgs/TFMessage"}
"""Classes of 2013 that have another name now."""


class MessageCodec(Protocol):
    """Codec of the messages in one direction of an interface on a robot."""

    def read(self, message: Any) -> bytes:
        """Return a message of the robot as JSON; raises ``MalformedMessage`` if it is not one."""
        ...

    def write(self, payload: bytes) -> Any:
        """Return a message as the robot expects it, from JSON; bytes in it are binary parts."""
        ...


def graph_class(name: str) -> str:
    """Return a class of messages or services by its name in the graph of the clone.

    Raises
    ------
    UnknownType
        It is not the name of a type of ROS.
    """
    return ros1_type(CLASSES.get(name, name))


def codecs_of(kind: InterfaceType, class_name: str) -> tuple[MessageCodec, MessageCodec]:
    """Return the codecs of what an interface on a robot sends, and of what it receives.

    For a topic both are the same. A client of a service receives requests and sends responses; a provider sends
    requests and receives responses.

    Raises
    ------
    InvalidInput
        The interface belongs to a container.
    UnknownType
        The class is not known, and needed.
    """
    if kind.form is InterfaceForm.INTERFACE:
        raise InvalidInput(f"an interface on a robot is a converter or a forwarder, not {kind}")
    name = graph_class(class_name)
    if not kind.is_service:
        codec = _codec(kind.form, name, _message(name))
        return codec, codec
    request, response = _service(kind.form, name)
    return (response, request) if kind.role is InterfaceRole.SERVICE_CLIENT else (request, response)


def _service(form: InterfaceForm, name: str) -> tuple[MessageCodec, MessageCodec]:
    try:
        known = service_type(name)
    except UnknownType:
        request = response = None
    else:
        request, response = known.request, known.response
    package, _, short = name.partition("/")
    full = f"{package}/srv/{short}"
    return _codec(form, f"{full}_Request", request), _codec(form, f"{full}_Response", response)


def _codec(form: InterfaceForm, name: str, cls: type[Message] | None) -> MessageCodec:
    return Converter(cls) if form is InterfaceForm.CONVERTER else Forwarder(name)


def _message(name: str) -> type[Message] | None:
    try:
        return message_type(name)
    except UnknownType:
        return None  # of a topic of the robot's own, whose messages pass as they are
