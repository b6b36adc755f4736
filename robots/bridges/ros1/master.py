"""Master of ROS 1: its client, registrations that survive its restart, and the slave API that it calls.

Source: https://wiki.ros.org/ROS/Slave_API.
"""

import asyncio
import os
from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Iterable, Mapping
from typing import Any

from ppaas.errors import MalformedMessage
from ppaas.wire.names import ros1_type
from ppaas.wire.ros.graph import Kind
from ppaas.wire.ros.ros1_master import FAILURE, SUCCESS, Nodes, RegisteredNodes, read_state, read_types
from robots.bridges.core.notices import Notices
from robots.bridges.ros1.connections import NodeConnection, Ros1Publication, Ros1Service, Ros1Subscription
from robots.bridges.ros1.http import Method, call

MAX_CALLS = 4
"""Largest number of calls at once: rosmaster lets five connections wait."""


class Ros1Master:
    """Methods of a master.

    Parameters
    ----------
    uri, node, own : str
        URI of the master, and name and URI of the node.
    """

    def __init__(self, uri: str, node: str, own: str) -> None:
        self._uri, self._node, self._own = uri, node, own
        self._turn = asyncio.Semaphore(MAX_CALLS)

    async def state(self) -> RegisteredNodes:
        """Return the nodes that publish, subscribe and serve; all methods raise as `call`."""
        return read_state(await self._call("getSystemState"))

    async def types(self) -> dict[str, str]:
        """Return the types of all topics, spelled as in ROS 2."""
        return read_types(await self._call("getTopicTypes"))

    async def publish(self, topic: str, type_name: str) -> None:
        """Register a publisher."""
        await self._call("registerPublisher", topic, type_name, self._own)

    async def subscribe(self, topic: str, type_name: str) -> list[str]:
        """Register a subscriber; return the URIs of the nodes that publish the topic."""
        return read_uris(await self._call("registerSubscriber", topic, type_name, self._own))

    async def serve(self, service: str, data: str) -> None:
        """Register a service, served at the TCPROS URI ``data``."""
        await self._call("registerService", service, data, self._own)

    async def stop_publishing(self, topic: str) -> None:
        """Unregister a publisher."""
        await self._call("unregisterPublisher", topic, self._own)

    async def stop_subscribing(self, topic: str) -> None:
        """Unregister a subscriber."""
        await self._call("unregisterSubscriber", topic, self._own)

    async def stop_serving(self, service: str, data: str) -> None:
        """Unregister a service."""
        await self._call("unregisterService", service, data)

    async def _call(self, method: str, *arguments: str) -> Any:
        async with self._turn:
            return await call(self._uri, method, self._node, *arguments)


def read_uris(value: Any) -> list[str]:
    """Return a list of URIs.

    Raises
    ------
    MalformedMessage
        The value is not a list of URIs.
    """
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise MalformedMessage("no list of URIs")
    return value


# -- registrations of a node at a master -------------------------------------------------------------------------------

Key = tuple[Kind, str]
Named = Ros1Publication | Ros1Subscription | Ros1Service


class Registrations:
    """Registrations of one node.

    Parameters
    ----------
    master : Ros1Master
        The master.
    node : str
        Name of the node.
    data : str
        TCPROS URI of the node's services.
    publishers : callable
        Called with each topic to which a subscriber was registered, and the URIs of its publishers.
    notices : Notices
        Log.
    """

    def __init__(
        self, master: Ros1Master, node: str, data: str, publishers: Callable[[str, list[str]], None], notices: Notices
    ) -> None:
        self.master, self._publishers = master, publishers
        self._node, self._data, self._notices = node, data, notices
        self._registered: dict[Key, Named] = {}

    async def reconcile(self, state: RegisteredNodes, wanted: Mapping[Key, Named]) -> None:
        """Register what is wanted and not registered, and withdraw the rest.

        All is tried before an error is raised as by `Ros1Master`; what has failed is missing the next time.

        Parameters
        ----------
        state : RegisteredNodes
            State of the master.
        wanted : mapping
            Publications, subscriptions and services by kind and name.
        """
        await self._each(self._withdraw, self._registered.keys() - wanted.keys())
        missing = [key for key, one in wanted.items() if self._is_missing(key, one, state)]
        await self._each(lambda key: self._register(key, wanted[key]), missing)

    def forget(self, key: Key) -> None:
        """Register a publication, a subscription or a service once more at the next turn."""
        self._registered.pop(key, None)

    async def withdraw(self) -> None:
        """Unregister all; raises as `Ros1Master`."""
        await self._each(self._withdraw, list(self._registered))

    def _is_missing(self, key: Key, one: Named, state: RegisteredNodes) -> bool:
        kind, name = key
        nodes: Nodes = {
            Kind.PUBLISHER: state.publishers, Kind.SUBSCRIBER: state.subscribers, Kind.SERVER: state.services
        }[kind]  # fmt: skip
        registered = nodes.get(name, frozenset())
        others = registered - {self._node}
        if kind is Kind.SERVER and others:
            self._notices.warn(f"{name} is served by {', '.join(sorted(others))}, and so not by the cloud")
            return False
        return self._registered.get(key) is not one or self._node not in registered

    async def _register(self, key: Key, one: Named) -> None:
        kind, name = key
        if kind is Kind.SUBSCRIBER:
            uris = await self.master.subscribe(name, ros1_type(one.type))
            self._publishers(name, uris)
        elif kind is Kind.PUBLISHER:
            await self.master.publish(name, ros1_type(one.type))
        else:
            await self.master.serve(name, self._data)
        self._registered[key] = one

    async def _withdraw(self, key: Key) -> None:
        kind, name = key
        if kind is Kind.SUBSCRIBER:
            await self.master.stop_subscribing(name)
        elif kind is Kind.PUBLISHER:
            await self.master.stop_publishing(name)
        else:
            await self.master.stop_serving(name, self._data)
        del self._registered[key]

    @staticmethod
    async def _each(work: Callable[[Key], Awaitable[None]], keys: "set[Key] | list[Key]") -> None:
        for result in await asyncio.gather(*map(work, keys), return_exceptions=True):
            if isinstance(result, BaseException):
                raise result


# -- slave API ---------------------------------------------------------------------------------------------------------

Response = tuple[int, str, Any]


class Slave(ABC):
    """Methods of a node; the changes that they ask for are made by the node itself."""

    master: str
    publications: Mapping[str, Ros1Publication]
    subscriptions: Mapping[str, Ros1Subscription]

    @abstractmethod
    def publishers_changed(self, topic: str, uris: list[str]) -> None:
        """Take the publishers of a topic that the node subscribes to."""

    @abstractmethod
    def told_to_end(self, reason: str) -> None:
        """Take the order to end."""

    @abstractmethod
    def data_address(self) -> tuple[str, int]:
        """Return host and port of the node's TCPROS server."""

    def methods(self) -> dict[str, Method]:
        """Return the methods by their names."""
        return {
            "publisherUpdate": self._publisher_update,
            "requestTopic": self._request_topic,
            "getPid": lambda _caller: (SUCCESS, "process id", os.getpid()),
            "getMasterUri": lambda _caller: (SUCCESS, "URI of the master", self.master),
            "getPublications": lambda _caller: (SUCCESS, "topics", _listed(self.publications.values())),
            "getSubscriptions": lambda _caller: (SUCCESS, "topics", _listed(self.subscriptions.values())),
            "getBusInfo": lambda _caller: (SUCCESS, "connections", self._bus_info()),
            "getBusStats": lambda _caller: (SUCCESS, "statistics", self._bus_stats()),
            "paramUpdate": lambda _caller, key, _value: (FAILURE, f"no parameter is followed, nor {key!s:.64}", 0),
            "shutdown": self._shutdown,
        }

    def _publisher_update(self, _caller: str, topic: str, publishers: list[str]) -> Response:
        self.publishers_changed(topic, read_uris(publishers))
        return SUCCESS, "taken", 0

    def _request_topic(self, _caller: str, topic: str, protocols: list[Any]) -> Response:
        if topic not in self.publications:
            return FAILURE, f"{topic!s:.64} is not published here", []
        if not any(isinstance(one, list) and one[:1] == ["TCPROS"] for one in protocols):
            return FAILURE, "only TCPROS is spoken here", []
        return SUCCESS, "ready", ["TCPROS", *self.data_address()]

    def _shutdown(self, _caller: str, reason: str = "") -> Response:
        self.told_to_end(str(reason)[:200])
        return SUCCESS, "ending", 0

    def _bus_info(self) -> list[list[Any]]:
        outward = [("o", peer.node, peer) for one in self.publications.values() for peer in one.peers]
        inward = [("i", uri, peer) for one in self.subscriptions.values() for uri, peer in one.peers.items()]
        return [
            [number, other, direction, "TCPROS", peer.topic, True]
            for number, (direction, other, peer) in enumerate(outward + inward, start=1)
        ]

    def _bus_stats(self) -> list[list[Any]]:
        published = [
            [one.name, sum(peer.bytes_carried for peer in one.peers), _carried(one.peers)]
            for one in self.publications.values()
        ]
        subscribed = [[one.name, _carried(one.peers.values())] for one in self.subscriptions.values()]
        return [published, subscribed, []]


def _carried(peers: Iterable[NodeConnection]) -> list[list[Any]]:
    """Return number, bytes, messages and state of each connection; XML-RPC has integers of 32 bits only."""
    top = 0x7FFFFFFF
    return [
        [number, min(peer.bytes_carried, top), min(peer.frames_carried, top), True]
        for number, peer in enumerate(peers, start=1)
    ]


def _listed(entities: Iterable[Ros1Publication | Ros1Subscription]) -> list[list[str]]:
    return [[one.name, ros1_type(one.type)] for one in entities]
