"""XML-RPC, by which nodes of ROS 1 and their master call each other: calls and responses as text.

A response of ROS is a list: a status, 1 if the call was successful, a text about it, and a value. The library
``xmlrpc`` of Python does the coding.

Source: https://wiki.ros.org/ROS/Master_API and https://wiki.ros.org/ROS/Slave_API.
"""

import binascii
import xmlrpc.client
from typing import Any, Final
from xml.parsers.expat import ExpatError

from ppaas.errors import MalformedMessage, MessageTooLarge, Unavailable

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
