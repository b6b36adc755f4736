"""Topics that robots on one map share: what the containers of a machine say to those of others, and hear of them."""

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
"""Topics that the robots on a map receive from each other."""

MAX_WAITING = 1 << 18
"""Bytes that may wait for a slow container before positions of others are dropped."""

MAX_SHARED = 1 << 16
"""Bytes of one message that is shared; it goes to every robot of the map."""


class Subscription(Protocol):
    """A subscription."""

    def close(self) -> None:
        """End it."""
        ...


class Fabric(Protocol):
    """What is asked of the fabric."""

    def publish(self, key: str, payload: bytes) -> None:
        """Publish; it may be lost."""
        ...

    def subscribe(self, key: str, callback: Callable[[str, bytes], None]) -> Subscription:
        """Call back with key and payload of what is published under a key expression."""
        ...


class FleetTopics:
    """What robots on one map share, for the containers of one machine.

    Parameters
    ----------
    fabric : Fabric
        By which other machines are reached.
    """

    def __init__(self, fabric: Fabric) -> None:
        self._fabric = fabric

    def share(self, scope: Scope | None, frame: machine_link.Share) -> None:
        """Publish what a container shares with other robots on its map.

        Raises
        ------
        NotPermitted
            It only plans.
        MessageTooLarge
            It would go to every robot of the map.
        """
        self._fabric.publish(_shared_key(frame, scope), frame.payload)

    def hear_others(self, scope: Scope | None, stream: FrameStream[machine_link.FromContainer]) -> list[Subscription]:
        """Send a container what the other robots on its map share, until the subscriptions returned are closed.

        A container that only plans receives nothing.
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
        raise NotPermitted("a container that only plans has nothing to share")
    if len(frame.payload) > MAX_SHARED:
        raise MessageTooLarge(f"{len(frame.payload)} bytes are over the limit of {MAX_SHARED}")
    return scope.shared_key(frame.topic)


def scope_of(spec: ContainerSpec) -> Scope | None:
    """Return what a container may read and write on the fabric; nothing, if it only plans."""
    if spec.robot is None:
        return None
    return Scope(spec.user, DEFAULT_GROUP, spec.robot.id, spec.map.id)
