"""Master of ROS 1: its state, and XML-RPC, by which nodes and the master call each other.

Source: ``getSystemState`` and ``getTopicTypes`` of https://wiki.ros.org/ROS/Master_API.
"""

import binascii
import xmlrpc.client
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final
from xml.parsers.expat import ExpatError

from ppaas.errors import MalformedMessage, MessageTooLarge, Unavailable
from ppaas.wire.names import ros2_type

# -- XML-RPC -----------------------------------------------------------------------------------------------------------

SUCCESS, FAILURE, ERROR = 1, 0, -1
"""Statuses of a response: done; not done; the call is wrong."""

MAX_CALL: Final = 1 << 20
"""Largest call that is read [bytes]."""

MAX_RESPONSE: Final = 8 << 20
"""Largest response that is read [bytes]: the state of a master with some ten thousand topics."""

_INVALID = (ExpatError, binascii.Error, ValueError, TypeError, LookupError, ArithmeticError, AttributeError)
"""Errors, besides its own, that ``xmlrpc`` raises for text that is not XML-RPC."""


def pack_call(method: str, *arguments: Any) -> bytes:
    """Return a call as text."""
    return xmlrpc.client.dumps(arguments, method, encoding="utf-8").encode()


def pack_response(status: int, text: str, value: Any) -> bytes:
    """Return a response of ROS as text."""
    return xmlrpc.client.dumps(([status, text, value],), methodresponse=True, encoding="utf-8").encode()


def pack_fault(text: str) -> bytes:
    """Return the response to a request that cannot be read as a call."""
    return xmlrpc.client.dumps(xmlrpc.client.Fault(1, text), encoding="utf-8").encode()


def unpack_call(data: bytes) -> tuple[str, tuple[Any, ...]]:
    """Return the method and the arguments of a call.

    Raises
    ------
    MessageTooLarge
        The text has more than `MAX_CALL` bytes.
    MalformedMessage
        The text is not a call of XML-RPC.
    """
    values, method = _loads(data, MAX_CALL)
    if not method:
        raise MalformedMessage("no call of XML-RPC: it names no method")
    return method, values


def unpack_response(data: bytes) -> Any:
    """Return the value of a response of ROS.

    Raises
    ------
    Unavailable
        The call failed; the text comes from the response.
    MessageTooLarge
        The text has more than `MAX_RESPONSE` bytes.
    MalformedMessage
        The text is not a response of ROS.
    """
    values, _ = _loads(data, MAX_RESPONSE)
    if len(values) != 1 or not isinstance(values[0], list) or len(values[0]) != 3:
        raise MalformedMessage("no response of ROS: it is not a list of status, text and value")
    status, text, value = values[0]
    if status != SUCCESS:
        raise Unavailable(str(text)[:500] or "it failed without a reason")
    return value


def _loads(data: bytes, limit: int) -> tuple[tuple[Any, ...], str | None]:
    if len(data) > limit:
        raise MessageTooLarge(f"XML-RPC of {len(data)} bytes; at most {limit} are read")
    if b"<!" in data:
        raise MalformedMessage("no XML-RPC: declarations of XML are not read")  # else entities could grow without end
    try:
        values, method = xmlrpc.client.loads(data.decode(), use_builtin_types=True)
    except xmlrpc.client.Fault as error:
        raise Unavailable(f"the call was refused: {error.faultString[:500]}") from error
    except (xmlrpc.client.Error, *_INVALID) as error:
        raise MalformedMessage(f"no XML-RPC: {error}") from error
    return values, method


# -- state of the master -----------------------------------------------------------------------------------------------

MAX_NAMES = 20_000
"""Largest number of topics and services of a master."""

SAME = {"tf/tfMessage": "tf2_msgs/msg/TFMessage"}
"""Types of older releases that are the same as one of Noetic."""

Nodes = Mapping[str, frozenset[str]]
"""Names of nodes, by the names of topics or services."""


@dataclass(frozen=True, slots=True)
class RegisteredNodes:
    """Nodes that are registered, by topic as publishers and subscribers, and by service."""

    publishers: Nodes
    subscribers: Nodes
    services: Nodes


def read_state(value: Any) -> RegisteredNodes:
    """Return the state in a response to ``getSystemState``.

    Raises
    ------
    MalformedMessage
        The value is not a state, or names more than `MAX_NAMES` topics or services.
    """
    if not isinstance(value, list) or len(value) != 3:
        raise MalformedMessage("no state of a master: it is not three lists")
    return RegisteredNodes(*map(_nodes, value))


def read_types(value: Any) -> dict[str, str]:
    """Return the types of topics in a response to ``getTopicTypes``, spelled as in ROS 2.

    Raises
    ------
    MalformedMessage
        The value is not a list of names and types.
    """
    if not isinstance(value, list) or len(value) > MAX_NAMES:
        raise MalformedMessage("no types of topics: it is not a list, or too long")
    found = {}
    for pair in value:
        if not isinstance(pair, list) or [type(one) for one in pair] != [str, str]:
            raise MalformedMessage("no types of topics: not each item is a name and a type")
        found[pair[0]] = SAME.get(pair[1]) or (ros2_type(pair[1], "msg") if "/" in pair[1] else "")
    return found


def _nodes(value: Any) -> Nodes:
    if not isinstance(value, list) or len(value) > MAX_NAMES:
        raise MalformedMessage("no state of a master: not a list of names, or too long")
    found = {}
    for pair in value:
        if not isinstance(pair, list) or len(pair) != 2 or not isinstance(pair[1], list):
            raise MalformedMessage("no state of a master: not each item is a name and its nodes")
        name, nodes = pair
        if not all(isinstance(one, str) for one in (name, *nodes)):
            raise MalformedMessage("no state of a master: a name is not text")
        found[name] = frozenset(nodes)
    return found
