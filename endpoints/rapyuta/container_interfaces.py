"""Interfaces in containers: topics and services of the clone."""

from typing import Protocol

from endpoints.clients.place_client import PlaceClient
from endpoints.rapyuta.interfaces import Answerer, Asker, Interface, Sink, Source
from engine.links.open_calls import Done
from engine.links.shared_place import check_type
from ppaas.errors import Conflict
from ppaas.wire.rapyuta.interface_types import InterfaceRole, InterfaceType
from ppaas.wire.rapyuta.message_codec import graph_class


class Graph(Protocol):
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
    graph : Graph
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
        graph: Graph,
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
