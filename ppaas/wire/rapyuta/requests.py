"""Requests of robots: the messages CC, DC, CN, CX and DM as typed structs.

Source: ``RobotWebSocketProtocol`` in ``rce/comm/server.py``. Fields that are not listed are ignored, as there.
"""

from collections.abc import Mapping
from typing import Annotated, Any, TypeAlias

import msgspec

from ppaas.decoding import converted
from ppaas.errors import MalformedMessage

MAX_MESSAGE_ID = 255
"""Longest id of a message [characters]."""

MAX_ITEMS = 1000
"""Largest number of items of one list of a configuration."""

_Text = Annotated[str, msgspec.Meta(max_length=4096)]
_Items = msgspec.Meta(max_length=MAX_ITEMS)


class ContainerData(msgspec.Struct):
    """Wishes for a container. A clone has the size of its robot's file, so they are read and not used."""

    size: int | None = 1
    cpu: float | None = None
    memory: float | None = None
    bandwidth: float | None = None
    group: _Text | None = None
    groupIp: _Text | None = None  # noqa: N815 - name on the wire
    specialFeatures: list[_Text] | None = None  # noqa: N815


class CreateContainer(msgspec.Struct):
    """CC: create a container."""

    containerTag: _Text  # noqa: N815
    containerData: ContainerData | None = None  # noqa: N815


class DestroyContainer(msgspec.Struct):
    """DC: destroy a container."""

    containerTag: _Text  # noqa: N815


class AddNode(msgspec.Struct):
    """Start a node in a container: the executable of a package, with arguments, name and namespace."""

    containerTag: _Text  # noqa: N815
    nodeTag: _Text  # noqa: N815
    pkg: _Text
    exe: _Text
    args: _Text = ""
    name: _Text = ""
    namespace: _Text = ""


class RemoveNode(msgspec.Struct):
    """Stop a node."""

    containerTag: _Text  # noqa: N815
    nodeTag: _Text  # noqa: N815


class AddInterface(msgspec.Struct):
    """Add an interface to a container, where ``addr`` is its topic or service, or to a robot."""

    endpointTag: _Text  # noqa: N815
    interfaceTag: _Text  # noqa: N815
    interfaceType: _Text  # noqa: N815
    className: _Text  # noqa: N815
    addr: _Text = ""


class RemoveInterface(msgspec.Struct):
    """Remove an interface."""

    endpointTag: _Text  # noqa: N815
    interfaceTag: _Text  # noqa: N815


class SetParameter(msgspec.Struct):
    """Set a parameter of ROS in a container."""

    containerTag: _Text  # noqa: N815
    name: _Text
    value: int | float | bool | str | list[Any]


class DeleteParameter(msgspec.Struct):
    """Delete a parameter."""

    containerTag: _Text  # noqa: N815
    name: _Text


class Configure(msgspec.Struct):
    """CN: change nodes, interfaces and parameters."""

    addNodes: Annotated[list[AddNode], _Items] = []  # noqa: N815
    removeNodes: Annotated[list[RemoveNode], _Items] = []  # noqa: N815
    addInterfaces: Annotated[list[AddInterface], _Items] = []  # noqa: N815
    removeInterfaces: Annotated[list[RemoveInterface], _Items] = []  # noqa: N815
    setParam: Annotated[list[SetParameter], _Items] = []  # noqa: N815
    deleteParam: Annotated[list[DeleteParameter], _Items] = []  # noqa: N815


class InterfacePair(msgspec.Struct):
    """Two interfaces, each as ``ENDPOINT/INTERFACE``."""

    tagA: _Text  # noqa: N815
    tagB: _Text  # noqa: N815


class Connect(msgspec.Struct):
    """CX: connect and disconnect interfaces."""

    connect: Annotated[list[InterfacePair], _Items] = []
    disconnect: Annotated[list[InterfacePair], _Items] = []


class DataMessage(msgspec.Struct):
    """DM: a message for an interface of the robot; binary parts of ``msg`` are bytes."""

    iTag: _Text  # noqa: N815
    type: _Text
    msgID: Annotated[str, msgspec.Meta(max_length=MAX_MESSAGE_ID)]  # noqa: N815
    msg: Any


Request: TypeAlias = CreateContainer | DestroyContainer | Configure | Connect | DataMessage

_KINDS: Mapping[str, type[Request]] = {
    "CC": CreateContainer,
    "DC": DestroyContainer,
    "CN": Configure,
    "CX": Connect,
    "DM": DataMessage,
}


def read_request(message: Any) -> Request:
    """Return the request in a message whose binary parts are in place.

    Raises
    ------
    MalformedMessage
        The message lacks a key, its type is not one of robots, or a field is invalid.
    """
    if not isinstance(message, dict):
        raise MalformedMessage("A message has to be an object with the keys 'type' and 'data'.")
    for key in ("type", "data"):
        if key not in message:
            raise MalformedMessage(f"Message is missing key: '{key}'")
    kind = _KINDS.get(message["type"]) if isinstance(message["type"], str) else None
    if kind is None:
        raise MalformedMessage(f"This message type is not supported: write one of {', '.join(_KINDS)}")
    try:
        return converted(message["data"], kind)
    except (msgspec.ValidationError, RecursionError) as error:
        raise MalformedMessage(f"Can not process the {message['type']} message: {error}") from error
