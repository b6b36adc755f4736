"""Graph of a ROS 2 system: the publishers, subscribers, servers and clients of its nodes."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

from ppaas.wire.ros.types import NO_HASH


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


TELLING: Mapping[str, str] = {
    "RIHS01_feb0bffee2e1c19bae16974eb939974eab100c13f941daf6402d605e4b3203e4": "jazzy",
    "RIHS01_7bc8b2d136804efa78de434256aa5274b0bd8af0fa8b8abee04c6617a4293fb7": "kilted",
    NO_HASH: "humble",
}
"""Releases by hashes that no other release has: those of FollowWaypoints' results, and the lack of hashes in Humble."""


def release_of(entities: Iterable[Entity]) -> str | None:
    """Return the release of ROS 2 by the hashes of types in the graph; None if none tells."""
    return next((TELLING[entity.type_hash] for entity in entities if entity.type_hash in TELLING), None)
