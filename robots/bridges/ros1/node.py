"""Node of ROS 1 without ROS: topics and services over TCPROS, found and registered at a master.

The state of the master is read four times a second. It shows which nodes there are, and whether this one is registered:
a master that was restarted has forgotten it, and learns it again. Nodes of rospy and roscpp do not register again, so
the connections that they have count as part of the graph, too.
"""

import asyncio
import contextlib
import ipaddress
import logging
import socket
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeVar

from ppaas.errors import Conflict, InvalidInput, PPaaSError, Unavailable
from ppaas.wire.names import MAX_NAME
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import Entity, Kind, Qos
from ppaas.wire.ros.ros1_master import RegisteredNodes
from ppaas.wire.ros.tcpros import unpack_header
from robots.bridges.core.notices import Notices
from robots.bridges.core.robot_graph import name_in_graph
from robots.bridges.core.transport import Answer, Closable, Publisher, Received, Transport
from robots.bridges.ros1.connections import NodeConnection, Ros1Publication, Ros1Service, Ros1Subscription
from robots.bridges.ros1.http import CALL_TIMEOUT, XmlRpcServer, address_of
from robots.bridges.ros1.master import Key, Named, Registrations, Ros1Master, Slave
from robots.bridges.ros1.move_base import ROS_1

logger = logging.getLogger("ppaas.bridge")

Closed = TypeVar("Closed", Ros1Publication, Ros1Subscription, Ros1Service)

POLL = 0.25
"""Time between two looks at the master [s]."""

MAX_PEERS = 512
"""Largest number of connections of other nodes to this one."""


@dataclass(frozen=True, slots=True)
class Ros1Options:
    """Options of a node of ROS 1.

    Parameters
    ----------
    master : str
        URI of the master.
    host : str
        Name or address of this computer that other nodes reach; empty for the address by which it reaches the master.
    """

    master: str
    host: str = ""


class Ros1Transport(Transport, Slave):
    """Transport over TCPROS.

    Parameters
    ----------
    options : Ros1Options
        Master, and address of this computer.
    name : str
        Name of the node, without a leading slash.

    Raises
    ------
    InvalidInput
        The URI of the master is invalid, or the extra ``ros1`` is not installed.
    """

    tables = ROS_1
    qos_matters = False
    not_found = "check ROS_MASTER_URI (--master) and that the robot runs"

    def __init__(self, options: Ros1Options, name: str = "ppaas_bridge") -> None:
        address_of(options.master)
        self.types = ros_types("noetic", ros2_times=True)
        self.master, self._name, self._host = options.master, f"/{name}", options.host
        self.publications: dict[str, Ros1Publication] = {}
        self.subscriptions: dict[str, Ros1Subscription] = {}
        self._services: dict[str, Ros1Service] = {}
        self._entities: dict[tuple[Kind, str, str], Entity] = {}
        self._state = RegisteredNodes({}, {}, {})
        self._known_types: dict[str, str] = {}
        self._peers: set[NodeConnection] = set()
        self._fault = ""
        self._notices = Notices()
        self._server = XmlRpcServer(self.methods())

    # -- node ----------------------------------------------------------------------------------------------------------

    async def open(self, changed: Callable[[], None]) -> None:
        """Start the node; the master may come later."""
        loop = asyncio.get_running_loop()
        self._changed, self._dirty, self._end = changed, asyncio.Event(), loop.create_future()
        self._host = self._host or await asyncio.to_thread(_own_address, *address_of(self.master))
        listen = self._host if _is_local(self._host) else "0.0.0.0"
        try:
            self._data = await loop.create_server(self._accept, listen, 0)
            self._uri = f"http://{self._host}:{await self._server.listen(listen)}/"
        except OSError as error:
            raise Unavailable(f"cannot listen on {listen}: {error}; name an address by --host") from error
        master, data = Ros1Master(self.master, self._name, self._uri), f"rosrpc://{self._host}:{self.data_address()[1]}"
        self._registry = Registrations(master, self._name, data, self.publishers_changed, self._notices)
        self._notices.info("types of messages are those of ROS 1 noetic")
        self._watching = asyncio.create_task(self._watch())

    async def close(self) -> None:
        """Withdraw all that is registered, and end the node."""
        if not hasattr(self, "_watching"):
            return
        self._watching.cancel()
        await asyncio.gather(self._watching, return_exceptions=True)
        for entity in self._wanted().values():
            entity.close()
        if not self._end.done():
            with contextlib.suppress(PPaaSError, TimeoutError):  # the master has gone, and with it what was registered
                async with asyncio.timeout(CALL_TIMEOUT):
                    await self._registry.withdraw()
        self._data.close()
        for peer in self._peers:
            peer.close()
        await self._server.close()

    async def ended(self) -> None:
        """Wait until the master or a user ends the node, and raise the reason."""
        await asyncio.wait({self._end, self._watching}, return_when=asyncio.FIRST_COMPLETED)
        for one in (self._end, self._watching):
            if one.done():
                one.result()

    # -- master --------------------------------------------------------------------------------------------------------

    async def _watch(self) -> None:
        began = True
        while True:
            self._dirty.clear()  # before the look: a change during it causes another one
            try:
                await self._look()
            except PPaaSError as error:
                if not self._fault:
                    logger.warning("the master does not answer, and is tried again: %s", error)
                self._fault = f"the master does not answer: {error}"
            else:
                if self._fault or began:
                    logger.info("the master is %s", self.master)
                    self._revive()
                self._fault, began = "", False
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(POLL):  # `wait_for` would ignore that it is cancelled, in Python 3.11
                    await self._dirty.wait()

    def faults(self) -> dict[str, str]:
        """Return the faults of the connections to the master and to publishers."""
        silent = {one.name: one.fault for one in self.subscriptions.values() if one.fault and not one.peers}
        return silent | ({"master": self._fault} if self._fault else {})

    def _revive(self) -> None:
        """End stalled connections, now that the network is back; else TCP would wait for up to two minutes.

        A subscriber on rospy connects again when the master names the publisher, and so the topic is registered again.
        """
        for publication in self.publications.values():
            stalled = [peer for peer in publication.peers if peer.stalled]
            for peer in stalled:
                peer.reset()
            if stalled:
                self._registry.forget((Kind.PUBLISHER, publication.name))
                self._dirty.set()

    async def _look(self) -> None:
        """Read the state of the master, and the types of topics if it has changed or one was not known."""
        state = await self._registry.master.state()
        topics = state.publishers.keys() | state.subscribers.keys()
        if state != self._state or not all(map(self._known_types.get, topics)):
            self._known_types = await self._registry.master.types()
            self._state = state
            self._refresh()
        await self._registry.reconcile(state, self._wanted())

    def _wanted(self) -> dict[Key, Named]:
        wanted: dict[Key, Named] = {(Kind.PUBLISHER, name): one for name, one in self.publications.items()}
        wanted |= {(Kind.SUBSCRIBER, name): one for name, one in self.subscriptions.items()}
        wanted |= {(Kind.SERVER, name): one for name, one in self._services.items()}
        return wanted

    def publishers_changed(self, topic: str, uris: list[str]) -> None:
        """Follow the publishers of a topic, this node excepted."""
        if topic in self.subscriptions:
            self.subscriptions[topic].update(uri for uri in uris if uri != self._uri)

    def told_to_end(self, reason: str) -> None:
        """End the node, as ``rosnode kill`` asks, or the master if another node has taken its name."""
        if not self._end.done():
            self._end.set_exception(
                Conflict(f"node {self._name} was told to end: {reason or 'no reason given'}; is there a second bridge?")
            )

    # -- graph ---------------------------------------------------------------------------------------------------------

    def entities(self) -> tuple[Entity, ...]:
        """Return the publishers and subscribers of the other nodes."""
        return tuple(self._entities.values())

    def _refresh(self) -> None:
        """Follow what the master or the connections show of the graph."""
        found: dict[tuple[Kind, str, str], Entity] = {}
        for kind, topics in ((Kind.PUBLISHER, self._state.publishers), (Kind.SUBSCRIBER, self._state.subscribers)):
            for topic, nodes in topics.items():
                self._add(found, kind, topic, self._known_types.get(topic, ""), ((node, "") for node in nodes))
        for subscription in self.subscriptions.values():
            connected = ((peer.node, uri) for uri, peer in subscription.peers.items())
            self._add(found, Kind.PUBLISHER, subscription.name, subscription.type, connected)
        for publication in self.publications.values():
            connected = ((peer.node, "") for peer in publication.peers)
            self._add(found, Kind.SUBSCRIBER, publication.name, publication.type, connected)
        if found != self._entities:
            self._entities = found
            self._changed()

    def _add(
        self,
        found: dict[tuple[Kind, str, str], Entity],
        kind: Kind,
        topic: str,
        type_name: str,
        nodes: Iterable[tuple[str, str]],
    ) -> None:
        for node, uri in nodes:
            # Relays of topic_tools subscribe without a type, and must be seen: they decide what reaches a base.
            if node != self._name and (type_name or kind is Kind.SUBSCRIBER):
                found[kind, topic, node] = Entity(kind, topic, type_name, Qos(), node, f"{topic} {node} {uri}")

    # -- topics and services -------------------------------------------------------------------------------------------

    def has_type(self, name: str) -> bool:
        """Return whether Noetic has a type."""
        return self.types.knows(name)

    def publisher(self, topic: str, type_name: str, qos: Qos) -> Publisher:
        """Return a publisher."""
        publication = Ros1Publication(
            self.types, self._name, topic, type_name, qos,
            changed=self._refresh, closed=self._closed(self.publications), notices=self._notices,
        )  # fmt: skip
        self.publications[topic] = publication
        self._dirty.set()
        return publication

    def subscribe(self, topic: str, type_name: str, qos: Qos, received: Received) -> Closable:
        """Subscribe to a topic."""
        subscription = Ros1Subscription(
            self.types, self._name, topic, type_name, received,
            changed=self._refresh, closed=self._closed(self.subscriptions), notices=self._notices,
        )  # fmt: skip
        self.subscriptions[topic] = subscription
        self._dirty.set()
        return subscription

    def serve(self, service: str, type_name: str, answer: Answer) -> Closable:
        """Serve a service."""
        served = Ros1Service(
            self.types, self._name, service, type_name, answer,
            closed=self._closed(self._services), notices=self._notices,
        )  # fmt: skip
        self._services[service] = served
        self._dirty.set()
        return served

    def _closed(self, table: dict[str, Closed]) -> Callable[[Closed], None]:
        def closed(entity: Closed) -> None:
            if table.get(entity.name) is entity:
                del table[entity.name]
            self._dirty.set()

        return closed

    # -- connections of other nodes ------------------------------------------------------------------------------------

    def data_address(self) -> tuple[str, int]:
        """Return host and port of the TCPROS server."""
        return self._host, self._data.sockets[0].getsockname()[1]

    def _accept(self) -> NodeConnection:
        peer = NodeConnection(self._greet)
        self._peers.add(peer)
        peer.lost.add_done_callback(lambda _: self._peers.discard(peer))
        if len(self._peers) > MAX_PEERS:
            asyncio.get_running_loop().call_soon(peer.abort)
        return peer

    def _greet(self, peer: NodeConnection, header: bytes) -> None:
        try:
            fields = unpack_header(header)
            peer.node = fields.get("callerid", "")[:MAX_NAME] or "a node without a name"
            peer.topic = fields.get("topic") or fields.get("service", "")
            offered = self.publications if "topic" in fields else self._services
            if peer.topic not in offered:
                raise InvalidInput(f"{peer.topic[:MAX_NAME]!r} is not offered by {self._name}")
            offered[peer.topic].accept(peer, fields)
        except InvalidInput as error:
            peer.send_header({"error": str(error)})
            peer.close()


def node_name(robot: str) -> str:
    """Return the name of the bridge's node for a robot: one a robot, so that several may share a master."""
    return f"ppaas_bridge_{name_in_graph(robot)}"


def _own_address(host: str, port: int) -> str:
    """Return the address of this computer by which it reaches a host."""
    try:
        family, kind, _, _, address = socket.getaddrinfo(host, port, socket.AF_INET, socket.SOCK_DGRAM)[0]
        with socket.socket(family, kind) as probe:
            probe.connect(address)
            own: str = probe.getsockname()[0]
            return own
    except OSError as error:
        raise InvalidInput(f"the master's host {host!r} cannot be reached: {error}; check ROS_MASTER_URI") from error


def _is_local(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
