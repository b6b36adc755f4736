"""Interfaces of robots and containers, the connections between them, and the endpoints that have them.

Messages pass from sources (subscribers) to sinks (publishers), requests from askers (providers of a service) to
answerers (clients of one). Between interfaces, messages are JSON of rosbridge.
"""

import logging
from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Callable
from typing import Any, Final, Protocol
from uuid import uuid4

from endpoints.place_client import MAX_WAITING, PlaceClient
from engine.links.open_calls import Done, OpenCalls, Outcome
from engine.links.shared_place import check_type
from engine.sessions.calls import CALL_TIMEOUT
from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError, QuotaExceeded, Unavailable
from ppaas.listener_faults import ListenerFaults
from ppaas.wire.rapyuta.answers import AnswerFrames, data_message, error_message, interface_status
from ppaas.wire.rapyuta.interface_types import InterfaceRole, InterfaceType, check_joinable
from ppaas.wire.rapyuta.message_codec import codecs_of, graph_class
from ppaas.wire.rapyuta.requests import DataMessage, InterfacePair
from ppaas.wire.rapyuta.tags import split_address

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


# Interfaces in containers: topics and services of the clone.


class CloneGraph(Protocol):
    """Graph of a clone, as interfaces use it."""

    @property
    def robot(self) -> str:
        """Robot whose clone it is."""
        ...

    @property
    def client(self) -> PlaceClient:
        """Current client of the clone's place."""
        ...


class ContainerInterface(Interface):
    """Interface in a container.

    Parameters
    ----------
    container, tag, kind, class_name
        See `Interface`.
    name : str
        Topic or service of the clone.
    graph : CloneGraph
        Graph of the clone.
    """

    def __init__(
        self,
        container: str,
        tag: str,
        kind: InterfaceType,
        class_name: str,
        *,
        name: str,
        graph: CloneGraph,
    ) -> None:
        super().__init__(container, tag, kind, class_name)
        self.name = name
        self._class = graph_class(class_name)
        self._graph = graph

    @property
    def graph_name(self) -> tuple[str, str]:
        """Robot whose clone has the topic or service, and its name."""
        return self._graph.robot, self.name

    def open(self) -> None:
        """Begin to use the clone, also after it was started again.

        Raises
        ------
        Conflict
            The topic or service has another type.
        """


class ContainerPublisher(ContainerInterface, Sink):
    """Publisher in a container."""

    _advertisement: tuple[PlaceClient, str] | None = None

    def open(self) -> None:
        """Advertise the topic."""
        client = self._graph.client
        self._advertisement = client, client.advertise(self.name, self._class)

    def deliver(self, payload: bytes, topic: str) -> None:
        """Publish a message."""
        self._graph.client.publish(self.name, payload)

    def close(self) -> None:
        """Withdraw the advertisement."""
        if self._advertisement is not None:
            client, advertisement = self._advertisement
            self._advertisement = None
            client.unadvertise(self.name, advertisement)


class ContainerSubscriber(ContainerInterface, Source):
    """Subscriber in a container; it subscribes while it has peers."""

    _subscribed: PlaceClient | None = None
    _counted = 0

    def open(self) -> None:
        """Check the type of the topic, and subscribe if there are peers."""
        self._subscribed, self._counted = None, 0
        known = self._graph.client.place.topic_type(self.name)
        if known is not None:
            check_type(self.name, known, self._class)
        self.peers_changed()

    def peers_changed(self) -> None:
        """Subscribe for the first peer; and again for each further one, which gets a latched message so."""
        before, self._counted = self._counted, len(self.peers)
        if self._counted > before:
            client = self._graph.client
            client.subscribe(self.name, self._class, self._heard)
            self._subscribed = client
        elif not self._counted and self._subscribed is not None:
            self._subscribed.unsubscribe(self.name, self._heard)
            self._subscribed = None

    def _heard(self, payload: bytes) -> None:
        self.forward(payload, self.name)


class ContainerServiceClient(ContainerInterface, Answerer):
    """Client of a service in a container: it calls the clone."""

    def open(self) -> None:
        """Check the type of the service."""
        known = self._graph.client.place.service_type(self.name)
        if known not in (None, self._class):
            raise Conflict(f"service {self.name!r} has type {known}, not {self._class}")

    def request(self, payload: bytes, done: Done) -> None:
        """Call the service."""
        self._graph.client.call(self.name, payload, done)


class ContainerServiceProvider(ContainerInterface, Asker):
    """Provider of a service in a container: what the clone and its clients ask goes to the peer."""

    def open(self) -> None:
        """Offer the service."""
        self._graph.client.offer(self.name, self._class, self.ask)

    def close(self) -> None:
        """Withdraw the service."""
        self._graph.client.withdraw(self.name)


CONTAINER_INTERFACES: dict[InterfaceRole, type[ContainerInterface]] = {
    InterfaceRole.PUBLISHER: ContainerPublisher,
    InterfaceRole.SUBSCRIBER: ContainerSubscriber,
    InterfaceRole.SERVICE_CLIENT: ContainerServiceClient,
    InterfaceRole.SERVICE_PROVIDER: ContainerServiceProvider,
}


# Interfaces on robots: converters and forwarders, which exchange messages with the robot by DM.

Send = Callable[[AnswerFrames, str | None], None]
"""Called with frames for the robot, and the topic of which they are a message; None if they must not be dropped."""


class RobotInterface(Interface):
    """Interface on a robot.

    Parameters
    ----------
    robot, tag, kind, class_name
        See `Interface`.
    send : callable
        Sends frames to the robot.

    Raises
    ------
    InvalidInput
        The type belongs to an interface in a container, or the class is not known to a forwarder.
    """

    def __init__(self, robot: str, tag: str, kind: InterfaceType, class_name: str, send: Send) -> None:
        super().__init__(robot, tag, kind, class_name)
        self._send = send
        self._reads, self._writes = codecs_of(kind, class_name)
        self._active = False

    def peers_changed(self) -> None:
        """Notify the robot that the interface was connected or disconnected."""
        if self._active is not bool(self.peers):
            self._active = bool(self.peers)
            self._send(interface_status(self.tag, active=self._active), None)

    def take(self, message: DataMessage) -> None:
        """Take a message of the robot.

        Raises
        ------
        InvalidInput
            Its class is not the interface's, or it is not a message of this class.
        """
        if message.type != self.class_name:
            raise InvalidInput(
                f"Sent message type does not match the used message type for this interface: {self.tag!r} has "
                f"{self.class_name}, not {message.type[:64]!r}"
            )
        self._taken(message.msg, message.msgID)

    def _taken(self, message: Any, message_id: str) -> None:
        raise InvalidInput(f"This converter can not handle incoming messages: {self.tag!r} is a {self.kind}")

    def _put(self, payload: bytes, message_id: str, topic: str | None = None) -> None:
        frames = data_message(self.tag, self.class_name, message_id, self._writes.write(payload))
        self._send(frames, topic)


class RobotSubscriber(RobotInterface, Source):
    """Subscriber on a robot: the robot sends messages."""

    def _taken(self, message: Any, message_id: str) -> None:
        self.forward(self._reads.read(message), self.tag)


class RobotPublisher(RobotInterface, Sink):
    """Publisher on a robot: the robot receives messages."""

    def deliver(self, payload: bytes, topic: str) -> None:
        """Send a message to the robot."""
        self._put(payload, uuid4().hex, topic)


class RobotServiceProvider(RobotInterface, Asker):
    """Provider of a service on a robot: the robot sends requests, and receives responses with the same id."""

    def _taken(self, message: Any, message_id: str) -> None:
        def done(outcome: Outcome) -> None:
            try:
                if isinstance(outcome, PPaaSError):
                    raise outcome
                self._put(outcome, message_id)
            except PPaaSError as error:
                text = f"request {message_id!r} of interface {self.tag!r} failed: {error.public}"
                self._send(error_message(Unavailable(text)), None)

        self.ask(self._reads.read(message), done)


class RobotServiceClient(RobotInterface, Answerer):
    """Client of a service on a robot: the robot receives requests, and sends responses with the same id."""

    def __init__(self, robot: str, tag: str, kind: InterfaceType, class_name: str, send: Send) -> None:
        super().__init__(robot, tag, kind, class_name, send)
        self._calls = OpenCalls()
        self._requests: dict[str, int] = {}

    def request(self, payload: bytes, done: Done) -> None:
        """Send a request to the robot.

        Raises
        ------
        QuotaExceeded
            The robot has not answered too many requests.
        """
        if len(self._requests) >= MAX_WAITING:
            raise QuotaExceeded(f"{MAX_WAITING} requests of interface {self.address!r} wait for the robot: try later")
        message_id = uuid4().hex

        def ended(outcome: Outcome) -> None:
            del self._requests[message_id]
            done(outcome)

        self._put(payload, message_id)
        self._requests[message_id] = self._calls.open(self.address, CALL_TIMEOUT, ended)

    def _taken(self, message: Any, message_id: str) -> None:
        number = self._requests.get(message_id)
        if number is None:
            raise InvalidInput(f"Service Client does not wait for a response with message ID {message_id[:64]!r}.")
        try:
            outcome: Outcome = self._reads.read(message)
        except PPaaSError as error:
            self._calls.end(number, error)
            raise
        self._calls.end(number, outcome)

    def close(self) -> None:
        """Fail the requests that the robot has not answered."""
        self._calls.fail(Unavailable(f"the interface {self.address!r} was removed before it answered"))


ROBOT_INTERFACES: dict[InterfaceRole, type[RobotInterface]] = {
    InterfaceRole.SUBSCRIBER: RobotSubscriber,
    InterfaceRole.PUBLISHER: RobotPublisher,
    InterfaceRole.SERVICE_PROVIDER: RobotServiceProvider,
    InterfaceRole.SERVICE_CLIENT: RobotServiceClient,
}


# Endpoints of one user: robots and containers by tag, which share one name space.

MAX_INTERFACES = 200
"""Largest number of interfaces of one endpoint."""

MAX_ENDPOINTS = 1000
"""Largest number of robots and containers of one user."""


class RapyutaEndpoint:
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
        self._endpoints: dict[str, RapyutaEndpoint] = {}

    def __len__(self) -> int:
        """Return the number of endpoints."""
        return len(self._endpoints)

    def check_free(self, tag: str) -> None:
        """Raise ``Conflict`` if an endpoint has this tag, ``QuotaExceeded`` if there are too many."""
        if tag in self._endpoints:
            raise Conflict(f"ID is already used for a container or robot: '{tag}'")
        if len(self._endpoints) >= MAX_ENDPOINTS:
            raise QuotaExceeded(f"a user may have at most {MAX_ENDPOINTS} robots and containers")

    def all(self) -> tuple[RapyutaEndpoint, ...]:
        """Return all endpoints."""
        return tuple(self._endpoints.values())

    def add(self, endpoint: RapyutaEndpoint) -> None:
        """Add an endpoint; raises as ``check_free``."""
        self.check_free(endpoint.tag)
        self._endpoints[endpoint.tag] = endpoint

    def remove(self, endpoint: RapyutaEndpoint) -> None:
        """Remove an endpoint with its interfaces, if it is there."""
        endpoint.remove_interfaces()
        if self._endpoints.get(endpoint.tag) is endpoint:
            del self._endpoints[endpoint.tag]

    def endpoint(self, tag: str) -> RapyutaEndpoint:
        """Return an endpoint; ``NotFound`` if there is none of this tag."""
        if tag not in self._endpoints:
            raise NotFound("endpoint", tag, list(self._endpoints))
        return self._endpoints[tag]

    def connect(self, pair: InterfacePair) -> None:
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

    def disconnect(self, pair: InterfacePair) -> None:
        """Disconnect two interfaces; ``NotFound`` if they are not there, or not connected."""
        part(*self._pair(pair))

    def _pair(self, pair: InterfacePair) -> tuple[Interface, Interface]:
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
