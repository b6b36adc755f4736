"""Endpoints of one user: robots and containers by tag, which share one name space, and their interfaces."""

from collections import defaultdict

from endpoints.rapyuta.container_interfaces import ContainerInterface, ContainerSubscriber
from endpoints.rapyuta.interfaces import Interface, join, part, part_all
from ppaas.errors import Conflict, InvalidInput, NotFound, QuotaExceeded
from ppaas.wire.rapyuta.interface_types import InterfaceRole
from ppaas.wire.rapyuta.requests import Join
from ppaas.wire.rapyuta.tags import split_address

MAX_INTERFACES = 200
"""Largest number of interfaces of one endpoint."""

MAX_ENDPOINTS = 1000
"""Largest number of robots and containers of one user."""


class Endpoint:
    """Robot or container, with its interfaces by tag.

    Parameters
    ----------
    tag : str
        Tag of the endpoint.
    """

    def __init__(self, tag: str) -> None:
        self.tag = tag
        self.interfaces: dict[str, Interface] = {}

    def check_free(self, tag: str) -> None:
        """Raise unless an interface of this tag may be added.

        Raises
        ------
        Conflict
            There is one already.
        QuotaExceeded
            There are too many.
        """
        if tag in self.interfaces:
            raise Conflict(f"Can not use the same interface tag '{tag}' in the same endpoint '{self.tag}' twice.")
        if len(self.interfaces) >= MAX_INTERFACES:
            raise QuotaExceeded(f"endpoint {self.tag!r} may have at most {MAX_INTERFACES} interfaces")

    def interface(self, tag: str) -> Interface:
        """Return an interface; ``NotFound`` if there is none of this tag."""
        if tag not in self.interfaces:
            raise NotFound(f"interface of endpoint {self.tag!r}", tag, list(self.interfaces))
        return self.interfaces[tag]

    def remove_interface(self, tag: str) -> None:
        """Disconnect and remove an interface; ``NotFound`` if there is none of this tag."""
        interface = self.interface(tag)
        part_all(interface)
        del self.interfaces[tag]
        interface.close()

    def remove_interfaces(self) -> None:
        """Disconnect and remove all interfaces."""
        for tag in tuple(self.interfaces):
            self.remove_interface(tag)


class EndpointTable:
    """Endpoints of one user."""

    def __init__(self) -> None:
        self._endpoints: dict[str, Endpoint] = {}

    def __len__(self) -> int:
        """Return the number of endpoints."""
        return len(self._endpoints)

    def check_free(self, tag: str) -> None:
        """Raise ``Conflict`` if an endpoint has this tag, ``QuotaExceeded`` if there are too many."""
        if tag in self._endpoints:
            raise Conflict(f"ID is already used for a container or robot: '{tag}'")
        if len(self._endpoints) >= MAX_ENDPOINTS:
            raise QuotaExceeded(f"a user may have at most {MAX_ENDPOINTS} robots and containers")

    def all(self) -> tuple[Endpoint, ...]:
        """Return all endpoints."""
        return tuple(self._endpoints.values())

    def add(self, endpoint: Endpoint) -> None:
        """Add an endpoint; raises as ``check_free``."""
        self.check_free(endpoint.tag)
        self._endpoints[endpoint.tag] = endpoint

    def remove(self, endpoint: Endpoint) -> None:
        """Remove an endpoint with its interfaces, if it is there."""
        endpoint.remove_interfaces()
        if self._endpoints.get(endpoint.tag) is endpoint:
            del self._endpoints[endpoint.tag]

    def endpoint(self, tag: str) -> Endpoint:
        """Return an endpoint; ``NotFound`` if there is none of this tag."""
        if tag not in self._endpoints:
            raise NotFound("endpoint", tag, list(self._endpoints))
        return self._endpoints[tag]

    def connect(self, pair: Join) -> None:
        """Connect two interfaces.

        Raises
        ------
        NotFound
            There is no such endpoint or interface.
        InvalidInput
            The interfaces do not match, or messages would go round in a circle.
        Conflict
            They are connected already.
        """
        one, other = self._pair(pair)
        source, sink = (one, other) if one.kind.role is InterfaceRole.SUBSCRIBER else (other, one)
        if self._leads(sink, source):
            raise InvalidInput(f"messages from {source.address!r} to {sink.address!r} would come back again and again")
        join(one, other)

    def disconnect(self, pair: Join) -> None:
        """Disconnect two interfaces; ``NotFound`` if they are not there, or not connected."""
        part(*self._pair(pair))

    def _pair(self, pair: Join) -> tuple[Interface, Interface]:
        one, other = (
            self.endpoint(endpoint).interface(interface)
            for endpoint, interface in (split_address("tagA", pair.tagA), split_address("tagB", pair.tagB))
        )
        return one, other

    def _leads(self, sink: Interface, source: Interface) -> bool:
        """Return whether what is published by an interface of a container comes to another one, by containers alone."""
        if not isinstance(sink, ContainerInterface) or not isinstance(source, ContainerInterface):
            return False
        edges: defaultdict[tuple[str, str], set[tuple[str, str]]] = defaultdict(set)
        for endpoint in self._endpoints.values():
            for interface in endpoint.interfaces.values():
                if isinstance(interface, ContainerSubscriber):
                    peers = (peer for peer in interface.peers if isinstance(peer, ContainerInterface))
                    edges[interface.graph_name].update(peer.graph_name for peer in peers)
        reached, waiting = {sink.graph_name}, [sink.graph_name]
        while waiting:
            new = edges[waiting.pop()] - reached
            reached |= new
            waiting.extend(new)
        return source.graph_name in reached
