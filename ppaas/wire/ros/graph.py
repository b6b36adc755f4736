"""Graph of a ROS 2 system: the publishers, subscribers, servers and clients of its nodes."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

from ppaas.wire.ros.types import NO_HASH, RELEASES, ros_types


class Kind(Enum):
    """Kind of an entity."""

    PUBLISHER = "publisher"
    SUBSCRIBER = "subscriber"
    SERVER = "service server"
    CLIENT = "service client"


@dataclass(frozen=True, slots=True)
class Qos:
    """Quality of service of a topic.

    Parameters
    ----------
    reliable : bool
        Whether lost messages are sent again; else best effort.
    latched : bool
        Whether late subscribers get the last messages (transient local).
    depth : int
        Number of messages that are kept.
    """

    reliable: bool = True
    latched: bool = False
    depth: int = 10


SENSOR = Qos(reliable=False, depth=5)
"""Quality of service that matches all publishers, which ROS has for sensor data."""

LATCHED = Qos(latched=True, depth=1)
"""Quality of service of maps, and of all that is published once."""


@dataclass(frozen=True, slots=True)
class Entity:
    """Publisher, subscriber, server or client of a node.

    Parameters
    ----------
    kind : Kind
        Its kind.
    name : str
        Name of its topic or service, with a leading slash.
    type : str
        Type of its messages, or of its service: ``nav_msgs/msg/Path``, ``nav_msgs/srv/GetMap``.
    qos : Qos
        Its quality of service.
    node : str
        Name of its node, with its namespace; empty if unknown.
    id : str
        Identity of the entity, which no other has.
    type_hash : str
        Hash of the type; empty if unknown.
    """

    kind: Kind
    name: str
    type: str
    qos: Qos
    node: str
    id: str
    type_hash: str = ""


def release_of(entities: Iterable[Entity]) -> str | None:
    """Return the release of ROS 2 by the hashes of types in the graph; None if none tells."""
    candidates = [release for release in RELEASES if not ros_types(release).ros1]
    for entity in entities:
        if entity.type_hash == NO_HASH:
            return "humble"
        matching = [release for release in candidates if _has(release, entity)]
        if matching:
            candidates = matching
    return candidates[0] if len(candidates) == 1 else None


def _has(release: str, entity: Entity) -> bool:
    types = ros_types(release)
    return types.knows(entity.type) and types.type_hash(entity.type) == entity.type_hash
