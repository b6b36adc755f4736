"""Keys, liveliness tokens and attachments by which nodes of ROS 2 find and address each other over Zenoh.

==========  ============================================================================================================
key         ``DOMAIN/TOPIC/TYPE/HASH``, such as ``0/scan/sensor_msgs::msg::dds_::LaserScan_/RIHS01_…``
token       ``@ros2_lv/DOMAIN/SESSION/NODE/ENTITY/KIND/ENCLAVE/NAMESPACE/NAME``, and for all but nodes
            ``/TOPIC/TYPE/HASH/QOS``; slashes in names are ``%``
attachment  sequence number, time of sending [ns] and the identity (GID) of the sender, each as in CDR
==========  ============================================================================================================

Source: ``docs/design.md`` of ``ros2/rmw_zenoh``.
"""

import re
import struct
from dataclasses import dataclass
from typing import Final

from ppaas.errors import MalformedMessage
from ppaas.wire.ros.graph import Entity, Kind, Qos

_CODES: Final = {Kind.PUBLISHER: "MP", Kind.SUBSCRIBER: "MS", Kind.SERVER: "SS", Kind.CLIENT: "SC"}
_KINDS: Final = {code: kind for kind, code in _CODES.items()}
_TYPE = re.compile(r"(\w+)::(msg|srv|action)::dds_::(\w+)_", re.ASCII)
_ATTACHMENT = struct.Struct("<qqB16s")

MAX_TOKEN = 2048
"""Longest token that is read [characters]."""

DEFAULT_DEPTH = 42
"""Depth of a topic whose token states none."""


@dataclass(frozen=True, slots=True)
class ZenohNode:
    """Node of this process.

    Parameters
    ----------
    domain : int
        Domain of ROS (``ROS_DOMAIN_ID``).
    session : str
        Id of the Zenoh session.
    namespace, name : str
        Names of the node; the namespace is ``/`` or begins with a slash.
    """

    domain: int
    session: str
    namespace: str
    name: str

    @property
    def token(self) -> str:
        """Token that makes the node known."""
        return f"{self._head}/0/NN/{self._tail}"

    def entity_token(self, number: int, entity: Entity) -> str:
        """Return the token of an entity of this node; no other entity has its number."""
        topic = entity.name.replace("/", "%")
        described = f"{topic}/{dds_type(entity.type)}/{entity.type_hash}/{qos_text(entity.qos)}"
        return f"{self._head}/{number}/{_CODES[entity.kind]}/{self._tail}/{described}"

    @property
    def _head(self) -> str:
        return f"@ros2_lv/{self.domain}/{self.session}/0"

    @property
    def _tail(self) -> str:
        return f"%/{self.namespace.replace('/', '%')}/{self.name}"


def topic_key(domain: int, topic: str, type_name: str, type_hash: str = "*") -> str:
    """Return the key of a topic or a service; without a hash, the key of all hashes."""
    return f"{domain}/{topic.strip('/')}/{dds_type(type_name)}/{type_hash}"


def dds_type(name: str) -> str:
    """Return the name of a type, such as ``nav_msgs/msg/Path``, as keys have it."""
    package, kind, short = name.split("/")
    return f"{package}::{kind}::dds_::{short}_"


def ros_type(name: str) -> str:
    """Return the name of a type that is spelled as in keys.

    Raises
    ------
    MalformedMessage
        It is not spelled so.
    """
    match = _TYPE.fullmatch(name)
    if match is None:
        raise MalformedMessage(f"not the name of a type of DDS: {name[:64]!r}")
    return f"{match[1]}/{match[2]}/{match[3]}"


def qos_text(qos: Qos) -> str:
    """Return a quality of service as tokens have it; what is the default is left out."""
    return f"{'' if qos.reliable else 2}:{1 if qos.latched else ''}:1,{qos.depth}:,:,:,,"


def parse_token(token: str) -> Entity | None:
    """Return the entity of a token; None for the token of a node.

    Raises
    ------
    MalformedMessage
        It is not a token of rmw_zenoh.
    """
    parts = token.split("/") if len(token) <= MAX_TOKEN else []
    if len(parts) < 9 or parts[0] != "@ros2_lv":
        raise MalformedMessage(f"not a token of a node of ROS 2: {token[:64]!r}")
    kind, namespace, name = parts[5], parts[7].replace("%", "/"), parts[8]
    if kind == "NN":
        return None
    if kind not in _KINDS or len(parts) != 13:
        raise MalformedMessage(f"not a token of an entity of ROS 2: {token[:64]!r}")
    node = f"{namespace.rstrip('/')}/{name}"
    topic = parts[9].replace("%", "/")
    return Entity(_KINDS[kind], topic, ros_type(parts[10]), _qos(parts[12]), node, token, parts[11])


def _qos(text: str) -> Qos:
    fields = text.split(":")
    if len(fields) != 6:
        raise MalformedMessage(f"not a quality of service: {text[:64]!r}")
    _, _, depth = fields[2].partition(",")
    return Qos(
        fields[0] != "2", fields[1] == "1", int(depth) if depth.isascii() and depth.isdecimal() else DEFAULT_DEPTH
    )


def gid_of(token: str) -> bytes:
    """Return the identity (GID) of the entity that has a token: 16 bytes.

    Raises
    ------
    ImportError
        ``xxhash`` is not installed.
    """
    import xxhash  # noqa: PLC0415 - of the extra ros2

    return int(xxhash.xxh3_128_intdigest(token.encode())).to_bytes(16, "little")


def pack_attachment(sequence: int, stamp: int, gid: bytes) -> bytes:
    """Return the attachment of a message.

    Parameters
    ----------
    sequence : int
        Number of the message among its sender's, from 1; of a reply, the number of its request.
    stamp : int
        Time of sending [ns since the epoch].
    gid : bytes
        Identity of the sender; of a reply, the client's identity.
    """
    return _ATTACHMENT.pack(sequence, stamp, len(gid), gid)


def unpack_attachment(data: bytes) -> tuple[int, bytes]:
    """Return the sequence number and the sender of an attachment.

    Raises
    ------
    MalformedMessage
        It is not an attachment of rmw_zenoh.
    """
    if len(data) != _ATTACHMENT.size:
        raise MalformedMessage(f"not an attachment of rmw_zenoh: {len(data)} bytes")
    sequence, _, size, gid = _ATTACHMENT.unpack(data)
    if size != len(gid):
        raise MalformedMessage(f"not an attachment of rmw_zenoh: an identity of {size} bytes")
    return sequence, gid
