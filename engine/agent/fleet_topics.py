"""Fleet topics: the topics that robots on one map share, published and received for the containers of a machine."""

from collections.abc import Callable
from typing import Protocol

from engine.fabric.keys import Scope, parse_shared
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.specs.containers import ContainerSpec
from ppaas.errors import MessageTooLarge, NotPermitted
from ppaas.nodes.topics import TOPICS

DEFAULT_GROUP = "default"
SHARED_TOPICS = tuple(topic.name for topic in TOPICS.values() if topic.shared)
"""Names of the topics that the robots on a map receive from each other."""

MAX_WAITING = 1 << 18
"""Bytes queued for a slow container above which shared messages to it are dropped."""

MAX_SHARED = 1 << 16
"""Largest shared message [bytes]; it is sent to every robot on the map."""


class Subscription(Protocol):
    """Subscription to a key expression."""

    def close(self) -> None:
        """End it."""
        ...


class Fabric(Protocol):
    """Part of the fabric's session that fleet topics need."""

    def publish(self, key: str, payload: bytes) -> None:
        """Publish a payload; it may be lost."""
        ...

    def subscribe(self, key: str, callback: Callable[[str, bytes], None]) -> Subscription:
        """Call ``callback`` with key and payload of each publication that matches a key expression."""
        ...


class FleetTopics:
    """Publisher and subscriber of shared topics for the containers of one machine.

    Parameters
    ----------
    fabric : Fabric
        Session on the fabric.
    """

    def __init__(self, fabric: Fabric) -> None:
        self._fabric = fabric

    def share(self, scope: Scope | None, frame: machine_link.Share) -> None:
        """Publish what a container shares with other robots on its map.

        Raises
        ------
        NotPermitted
            The container only plans.
        MessageTooLarge
            The payload is over `MAX_SHARED` bytes.
        """
        self._fabric.publish(_shared_key(frame, scope), frame.payload)

    def hear_others(self, scope: Scope | None, stream: FrameStream[machine_link.FromContainer]) -> list[Subscription]:
        """Forward what other robots on its map share to a container, until the returned subscriptions are closed.

        A container without a scope receives nothing.
        """
        if scope is None:
            return []

        def heard(key: str, payload: bytes) -> None:
            other = parse_shared(key)
            itself = (other.user, other.robot) == (scope.user, scope.robot)
            if not itself and stream.waiting <= MAX_WAITING:
                stream.write(machine_link.Shared(other.user, other.robot, other.topic, payload))

        return [self._fabric.subscribe(scope.shared_pattern(topic), heard) for topic in SHARED_TOPICS]


def _shared_key(frame: machine_link.Share, scope: Scope | None) -> str:
    if scope is None:
        raise NotPermitted("a container that only plans has no topics to share")
    if len(frame.payload) > MAX_SHARED:
        raise MessageTooLarge(f"a shared message may have up to {MAX_SHARED} bytes, not {len(frame.payload)}")
    return scope.shared_key(frame.topic)


def scope_of(spec: ContainerSpec) -> Scope | None:
    """Return the scope in which a container may publish and subscribe.

    A robot that continues a published map shares with the robots on that map; one that makes a map from nothing with
    those whose maps may be joined with it. None if the container only plans.
    """
    if spec.robot is None:
        return None
    on = spec.robot.continued if spec.maps else spec.map
    return Scope(spec.user, DEFAULT_GROUP, spec.robot.id, spec.joint_map if on is None else on.id)
