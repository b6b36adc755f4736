"""Slave API: the methods of a node of ROS 1 that the master and other nodes call.

Source: https://wiki.ros.org/ROS/Slave_API.
"""

import os
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any

from ppaas.wire.names import ros1_type
from ppaas.wire.ros.ros1_master import FAILURE, SUCCESS
from robots.bridges.ros1.http import Method
from robots.bridges.ros1.master import read_uris
from robots.bridges.ros1.peer import Peer
from robots.bridges.ros1.publication import Publication
from robots.bridges.ros1.subscription import Subscription

Response = tuple[int, str, Any]


class Slave(ABC):
    """Methods of a node; the changes that they ask for are made by the node itself."""

    master: str
    publications: Mapping[str, Publication]
    subscriptions: Mapping[str, Subscription]

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


def _carried(peers: Iterable[Peer]) -> list[list[Any]]:
    """Return number, bytes, messages and state of each connection; XML-RPC has integers of 32 bits only."""
    top = 0x7FFFFFFF
    return [
        [number, min(peer.bytes_carried, top), min(peer.frames_carried, top), True]
        for number, peer in enumerate(peers, start=1)
    ]


def _listed(entities: Iterable[Publication | Subscription]) -> list[list[str]]:
    return [[one.name, ros1_type(one.type)] for one in entities]
