"""Graph of a ROS 2 system: the publishers, subscribers, servers and clients of its nodes."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

from ppaas.wire.ros.definitions import DEFINITIONS
from ppaas.wire.ros.types import NO_HASH, ROS_1

ROS_2_RELEASES = tuple(release for release in DEFINITIONS if release != ROS_1)
"""Releases of ROS 2 whose types are known, the oldest first."""


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


_NOT_LYRICAL, _LYRICAL = ("jazzy", "kilted"), ("lyrical",)
DISTINCTIVE: Mapping[str, tuple[str, ...]] = {
    NO_HASH: ("humble",),
    # Results of FollowWaypoints.
    "RIHS01_feb0bffee2e1c19bae16974eb939974eab100c13f941daf6402d605e4b3203e4": ("jazzy",),
    "RIHS01_7bc8b2d136804efa78de434256aa5274b0bd8af0fa8b8abee04c6617a4293fb7": ("kilted", "lyrical"),
    # lifecycle_msgs/TransitionEvent, which each lifecycle node publishes.
    "RIHS01_d5f8873a2f0146498f812d7885c7327ce27e463d36811d8792f35ee38c0d6c38": _NOT_LYRICAL,
    "RIHS01_78b19e2be41a797fc009c96bda68944182edabec7852cccd928a40bc06f6f9d7": _LYRICAL,
    # Feedback of NavigateToPose.
    "RIHS01_9d1f6fa2eb975ce733b419ac2e97b134d8ff92b6478b6559feed9a50bdfd82b3": _NOT_LYRICAL,
    "RIHS01_2c1b4ec1a0e3a53c9aa326aabe717670eeef0ff3d4c3351ff940613b2011728a": _LYRICAL,
    # ClearEntireCostmap.
    "RIHS01_553f54f9cadab44553fdf5627433fcb6701f71c1fc2eb55a7b4a004fdeeab952": _NOT_LYRICAL,
    "RIHS01_f6d3228ce896488e63003f99de655e742af27bcab2e75694f4eb8ca1604ccb3d": _LYRICAL,
}
"""Releases of ROS 2 by hashes that not all of them have."""


def release_of(entities: Iterable[Entity]) -> str | None:
    """Return the release of ROS 2 by the hashes of types in the graph; None if they fit several, or none.

    Of Kilted and Lyrical, whose difference a robot without Nav2's navigator does not show, it is Kilted. If nodes of
    several releases are in the graph, it is the release of the first node whose release is known.
    """
    found: list[tuple[str, ...]] = []
    for entity in entities:
        releases = DISTINCTIVE.get(entity.type_hash)
        if releases is not None and releases not in found:
            found.append(releases)
    common = [one for one in ROS_2_RELEASES if found and all(one in releases for releases in found)]
    if not common and found:
        return min(found, key=len)[0]
    return common[0] if len(common) == 1 or common == ["kilted", "lyrical"] else None
