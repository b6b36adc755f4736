"""Graph of ROS 2 in memory, with entities and messages set by the test."""

import itertools
from collections.abc import Callable
from typing import Any

from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import Entity, Kind, Qos
from robots.bridges.core.transport import Answer, Received, Transport


class _Closed:
    def __init__(self, close: Callable[[], object]) -> None:
        self._close = close

    def close(self) -> None:
        self._close()


class FakePublisher:
    """Publisher of the bridge, which keeps what it published."""

    def __init__(self, transport: "FakeTransport", topic: str, type_name: str, qos: Qos) -> None:
        self._transport, self.topic, self.type, self.qos = transport, topic, type_name, qos

    def publish(self, data: bytes) -> None:
        message = self._transport.types.decode(self.type, data)
        self._transport.published.setdefault(self.topic, []).append(message)

    def close(self) -> None:
        self._transport.publishers.remove(self)


class FakeTransport(Transport):
    """Transport whose robot is the test."""

    def __init__(self, release: str = "jazzy") -> None:
        self.types = ros_types(release)
        self.publishers: list[FakePublisher] = []
        self.published: dict[str, list[dict[str, Any]]] = {}
        self.subscriptions: dict[str, tuple[str, Qos, Received]] = {}
        self.servers: dict[str, tuple[str, Answer]] = {}
        self.graph: list[Entity] = []
        self.opened = False
        self.others: tuple[int, ...] = ()
        self.packages_missing: set[str] = set()
        self._numbers = itertools.count(1)

    async def open(self, changed: Callable[[], None]) -> None:
        self.changed, self.opened = changed, True
        changed()

    async def close(self) -> None:
        self.opened = False

    def entities(self) -> tuple[Entity, ...]:
        return tuple(self.graph)

    async def other_domains(self) -> tuple[int, ...]:
        return self.others

    def has_type(self, name: str) -> bool:
        return name.partition("/")[0] not in self.packages_missing

    def publisher(self, topic: str, type_name: str, qos: Qos) -> FakePublisher:
        self.publishers.append(FakePublisher(self, topic, type_name, qos))
        return self.publishers[-1]

    def subscribe(self, topic: str, type_name: str, qos: Qos, received: Received) -> _Closed:
        self.subscriptions[topic] = type_name, qos, received
        return _Closed(lambda: self.subscriptions.pop(topic))

    def serve(self, service: str, type_name: str, answer: Answer) -> _Closed:
        self.servers[service] = type_name, answer
        return _Closed(lambda: self.servers.pop(service))

    # -- the robot -----------------------------------------------------------------------------------------------------

    def has(self, kind: Kind, topic: str, type_name: str, qos: Qos | None = None) -> Entity:
        """Add an entity of the robot to the graph."""
        entity = Entity(kind, topic, type_name, qos or Qos(), "/robot", str(next(self._numbers)))
        self.graph.append(entity)
        return entity

    def say(self, topic: str, message: dict[str, Any]) -> None:
        """Publish a message of the robot."""
        type_name, _, received = self.subscriptions[topic]
        received(self.types.encode(type_name, message))

    async def call(self, service: str, request: dict[str, Any]) -> dict[str, Any]:
        """Call a service of the bridge."""
        type_name, answer = self.servers[service]
        response = await answer(self.types.encode(f"{type_name}_Request", request))
        return self.types.decode(f"{type_name}_Response", response)
