"""Interface of a transport: how a bridge takes part in the graph of a robot's ROS.

All methods are called, and all callbacks are called, on the event loop. Messages are bytes: CDR of ROS 2, or the
serialization of ROS 1.
"""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Mapping
from typing import Protocol

from ppaas.wire.ros import RosTypes
from ppaas.wire.ros.graph import Entity, Qos
from robots.bridges.core.tables import ROS_2, Tables

Received = Callable[[bytes], None]
"""Called with each message of a topic."""

Answer = Callable[[bytes], Awaitable[bytes]]
"""Called with a request; returns the response. A request whose answer raises gets none."""


class Closable(Protocol):
    """Entity of the bridge that can be removed from the graph."""

    def close(self) -> None:
        """Remove the entity."""
        ...


class Publisher(Closable, Protocol):
    """Publisher of the bridge."""

    def publish(self, data: bytes) -> None:
        """Publish a message."""
        ...


class Transport(ABC):
    """Node of the bridge in the graph.

    Attributes
    ----------
    types : RosTypes
        Types of the robot's release of ROS; valid after ``open``.
    tables : Tables
        Names that the robot's nodes have for topics, services and actions.
    not_found : str
        Advice for a user whose robot is not in the graph.
    lacking : str
        What the transport cannot do, as a sentence for the user; empty if it can do all.
    services : bool
        Whether the transport can serve services, and so actions.
    qos_matters : bool
        Whether publishers and subscribers are connected only if their qualities of service match.
    domain : int
        Domain of ROS 2.
    """

    types: RosTypes
    tables: Tables = ROS_2
    not_found: str = "check ROS_DOMAIN_ID (--domain) and that the robot runs"
    lacking: str = ""
    services: bool = True
    qos_matters: bool = True
    domain: int = 0

    @abstractmethod
    async def open(self, changed: Callable[[], None]) -> None:
        """Join the graph.

        Parameters
        ----------
        changed : callable
            Called when entities have joined or left.

        Raises
        ------
        PPaaSError
            The transport cannot be opened, and why.
        """

    @abstractmethod
    async def close(self) -> None:
        """Leave the graph."""

    async def ended(self) -> None:
        """Wait until the robot's side ends the bridge for good, and raise the reason."""
        await asyncio.Event().wait()

    @abstractmethod
    def entities(self) -> tuple[Entity, ...]:
        """Return the entities of the other nodes."""

    def faults(self) -> Mapping[str, str]:
        """Return the faults between the bridge and the robot's nodes that are there now, by subject."""
        return {}

    async def other_domains(self) -> tuple[int, ...]:
        """Return the other domains in which robots are, as far as the transport can see them."""
        return ()

    def has_type(self, name: str) -> bool:
        """Return whether the transport can carry a type, given its full name."""
        return True

    @abstractmethod
    def publisher(self, topic: str, type_name: str, qos: Qos) -> Publisher:
        """Return a new publisher of a topic, whose name begins with a slash."""

    @abstractmethod
    def subscribe(self, topic: str, type_name: str, qos: Qos, received: Received) -> Closable:
        """Subscribe to a topic, whose name begins with a slash."""

    def serve(self, service: str, type_name: str, answer: Answer) -> Closable:
        """Serve a service, whose name begins with a slash; only if ``services``."""
        raise NotImplementedError
