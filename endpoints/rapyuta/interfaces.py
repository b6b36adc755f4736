"""Interfaces of endpoints, and the connections between them.

Messages pass from sources (subscribers) to sinks (publishers), requests from askers (providers of a service) to
answerers (clients of one). Between interfaces, messages are JSON of rosbridge.
"""

import logging
from abc import ABC, abstractmethod
from typing import Final

from engine.links.open_calls import Done
from ppaas.errors import Conflict, NotFound, QuotaExceeded, Unavailable
from ppaas.listener_faults import ListenerFaults
from ppaas.wire.rapyuta.interface_types import InterfaceType, check_joinable

_faults = ListenerFaults(logging.getLogger(__name__))

MAX_PEERS = 32
"""Largest number of interfaces that one interface is connected to."""


class Interface:
    """Interface of an endpoint.

    Parameters
    ----------
    endpoint, tag : str
        Tags of the endpoint and of the interface.
    kind : InterfaceType
    class_name : str
        Class of the messages or the service, as the robot spells it.

    Attributes
    ----------
    peers : list of Interface
        Interfaces that it is connected to.
    """

    max_peers = MAX_PEERS

    def __init__(self, endpoint: str, tag: str, kind: InterfaceType, class_name: str) -> None:
        self.address: Final = f"{endpoint}/{tag}"
        self.tag: Final = tag
        self.kind: Final = kind
        self.class_name: Final = class_name
        self.peers: list[Interface] = []

    def peers_changed(self) -> None:
        """Handle another number of peers; raises if the interface cannot be connected."""

    def close(self) -> None:
        """Release what the interface uses; it has no peers any more."""


class Sink(Interface, ABC):
    """Interface that messages pass to."""

    @abstractmethod
    def deliver(self, payload: bytes, topic: str) -> None:
        """Deliver a message as JSON; ``topic`` is its source's topic."""


class Source(Interface):
    """Interface that messages come from."""

    def forward(self, payload: bytes, topic: str) -> None:
        """Pass a message, as JSON, to all peers; the first error of one is raised once all have got it."""
        errors = []
        for peer in tuple(self.peers):
            assert isinstance(peer, Sink)
            errors.append(_faults.deliver(f"interface {peer.address!r}", peer.deliver, payload, topic))
        for error in filter(None, errors):
            raise error


class Answerer(Interface, ABC):
    """Interface that requests pass to."""

    @abstractmethod
    def request(self, payload: bytes, done: Done) -> None:
        """Pass a request, as JSON, to the service; ``done`` is called with the outcome."""


class Asker(Interface):
    """Interface that requests come from; it has one peer."""

    max_peers = 1

    def ask(self, payload: bytes, done: Done) -> None:
        """Pass a request, as JSON, to the peer.

        Raises
        ------
        Unavailable
            There is no peer.
        """
        if not self.peers:
            raise Unavailable(f"interface {self.address!r} is not connected: nobody answers the request")
        [peer] = self.peers
        assert isinstance(peer, Answerer)
        peer.request(payload, done)


def join(one: Interface, other: Interface) -> None:
    """Connect two interfaces.

    Raises
    ------
    InvalidInput
        Their types do not match.
    Conflict
        They are connected already.
    QuotaExceeded
        One of them has too many peers.
    """
    check_joinable((one.kind, one.class_name), (other.kind, other.class_name))
    if other in one.peers:
        raise Conflict(f"{one.address!r} and {other.address!r} are connected already")
    for interface in (one, other):
        if len(interface.peers) >= interface.max_peers:
            raise QuotaExceeded(f"interface {interface.address!r} may be connected to {interface.max_peers} at most")
    one.peers.append(other)
    other.peers.append(one)
    try:
        one.peers_changed()
        other.peers_changed()
    except BaseException:
        part(one, other)
        raise


def part(one: Interface, other: Interface) -> None:
    """Disconnect two interfaces; ``NotFound`` if they are not connected."""
    if other not in one.peers:
        raise NotFound("connection", f"{one.address} {other.address}")
    one.peers.remove(other)
    other.peers.remove(one)
    one.peers_changed()
    other.peers_changed()


def part_all(interface: Interface) -> None:
    """Disconnect an interface from all others."""
    for peer in tuple(interface.peers):
        part(interface, peer)
