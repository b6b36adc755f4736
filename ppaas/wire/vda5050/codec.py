"""Codec of VDA 5050: messages as JSON of a version, and back.

Received messages are checked for what the schemas require: fields that must be there, types, and values of
enumerations. Unknown fields are ignored, and optional ones may be left out. Parts of a factsheet may be left out, too,
and count as left out if they cannot be read; the size of the AGV is refused instead.
"""

import re
from typing import Any

import msgspec

from ppaas.decoding import converted
from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge
from ppaas.wire.vda5050 import spelling, topics
from ppaas.wire.vda5050.factsheets import Factsheet
from ppaas.wire.vda5050.fields import Fields
from ppaas.wire.vda5050.headers import MessageHeader
from ppaas.wire.vda5050.orders import InstantActions, Order
from ppaas.wire.vda5050.states import Connection, State, Visualization
from ppaas.wire.vda5050.topics import Version, understand
from ppaas.wire.vda5050.zones import Responses, ZoneSet

MAX_PAYLOAD = 1 << 20
"""Largest payload [bytes]."""

MAX_LEVELS = 32
"""Largest depth of dicts and lists in a payload."""

BODIES: dict[str, type[Fields]] = {
    topics.ORDER: Order,
    topics.INSTANT_ACTIONS: InstantActions,
    topics.STATE: State,
    topics.CONNECTION: Connection,
    topics.FACTSHEET: Factsheet,
    topics.VISUALIZATION: Visualization,
    topics.RESPONSES: Responses,
    topics.ZONE_SET: ZoneSet,
}
"""Messages without their headers, by the last level of the topic."""

HEADLESS_2 = frozenset({topics.FACTSHEET, topics.VISUALIZATION})
"""Topics whose messages may lack the header in 2.x."""

NO_HEADER = {"headerId": 0, "timestamp": "", "version": "2.1.0", "manufacturer": "", "serialNumber": ""}

_QUOTED, _NAME = re.compile("`[^`]*`"), re.compile(r"\w+")


def encode(topic: str, header: MessageHeader, body: Fields, version: Version) -> bytes:
    """Return a message as JSON.

    Parameters
    ----------
    topic : str
        Last level of the topic.
    header : MessageHeader
    body : Fields
        Message of that topic.
    version : Version
        Version whose names the message has.
    """
    tree = msgspec.to_builtins(body)
    spelled = spelling.to_version_3(topic, tree) if version.major >= 3 else spelling.to_version_2(topic, tree)
    if version is Version.V2_0 and topic == topics.INSTANT_ACTIONS:
        spelled[topic] = spelled["actions"]  # the schema of 2.0 has one name of the list, its text the other
    return msgspec.json.encode({**msgspec.to_builtins(header), **spelled})


def decode(topic: str, payload: bytes, version: Version) -> tuple[MessageHeader, Any]:
    """Return the header and the body of a message, a struct of ``BODIES``.

    Parameters
    ----------
    topic : str
        Last level of the topic.
    payload : bytes
        JSON in UTF-8.
    version : Version
        Version that this side speaks; the message may be of another minor version.

    Raises
    ------
    MessageTooLarge
        The payload is larger than 1 MiB.
    MalformedMessage
        The payload is not a JSON object, or a field is missing, of another type or out of range; the error names it.
    InvalidInput
        The topic is unknown, or the message is of another major version.
    """
    body = BODIES.get(topic)
    if body is None:
        raise InvalidInput(f"unknown topic {topic[:40]!r}; known: {', '.join(BODIES)}")
    tree = _object(topic, payload)
    if version.major < 3:
        tree = spelling.from_version_2(topic, tree)
        tree = {**NO_HEADER, **tree} if topic in HEADLESS_2 else tree
    else:
        tree = spelling.from_version_3(topic, tree)
    try:
        header = converted(tree, MessageHeader)
        decoded = converted(_without_unreadable_parts(tree) if body is Factsheet else tree, body)
    except msgspec.ValidationError as error:
        raise MalformedMessage(f"{topic}: {_told(topic, str(error), version)}") from error
    if not understand(version, header.version):
        raise InvalidInput(f"{topic}: field 'version' is {header.version[:20]!r}, but {version.value} is spoken here")
    return header, decoded


def _without_unreadable_parts(sheet: dict[str, Any]) -> dict[str, Any]:
    """Return a factsheet without the parts that cannot be read, except the size: a robot is driven by it."""
    return {name: part for name, part in sheet.items() if name == "physicalParameters" or _is_readable(name, part)}


def _is_readable(name: str, part: Any) -> bool:
    try:
        converted({name: part}, Factsheet)
    except msgspec.ValidationError:
        return False
    return True


def _object(topic: str, payload: bytes) -> dict[str, Any]:
    """Return the object that a payload is."""
    if len(payload) > MAX_PAYLOAD:
        raise MessageTooLarge(f"{topic}: a message may have {MAX_PAYLOAD} bytes, not {len(payload)}")
    try:
        tree = msgspec.json.decode(payload)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise MalformedMessage(f"{topic}: not JSON: {error}") from error
    if not isinstance(tree, dict):
        raise MalformedMessage(f"{topic}: a JSON object is expected")
    if _deep(tree, MAX_LEVELS):
        raise MalformedMessage(f"{topic}: objects and lists are nested in more than {MAX_LEVELS} levels")
    return tree


def _deep(tree: Any, levels: int) -> bool:
    """Return whether dicts and lists are nested in more than some levels."""
    if isinstance(tree, dict):
        tree = tree.values()
    elif not isinstance(tree, list):
        return False
    return levels <= 0 or any(_deep(one, levels - 1) for one in tree)


def _told(topic: str, text: str, version: Version) -> str:
    """Return an error of msgspec, whose quoted names are fields, with the names that the sender used."""
    if version.major >= 3:
        return text
    return _QUOTED.sub(lambda quoted: _NAME.sub(lambda one: spelling.name_in_version_2(topic, one[0]), quoted[0]), text)
