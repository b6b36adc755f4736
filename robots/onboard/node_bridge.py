"""Topics and services of local nodes: between the nodes, the robot's client, and the cloud."""

import asyncio
import logging
from collections import deque
from collections.abc import Collection, Sequence

from ppaas.errors import Conflict
from ppaas.messages import Message, ServiceType, decode, encode, message_type, service_type
from ppaas.messages.ppaas_msgs import TopicMessage
from ppaas.nodes.message_checks import fingerprint
from ppaas.nodes.topics import policy_of
from robots.client.robot_client import RobotClient
from robots.client.services import Handler
from robots.client.subscription import TopicSubscription
from robots.onboard.executor import protocol
from robots.onboard.node_process import NodeProcess
from robots.onboard.stop_latch import OnboardLatch

logger = logging.getLogger(__name__)

# -- topics of local nodes ---------------------------------------------------------------------------------------------

MAX_WAITING = 1000
"""Messages of local nodes that are kept while the link is down."""

MAX_HEARD = 100
"""Number of fingerprints kept per node, of the last guaranteed messages that it received."""


class TopicBridge:
    """Forwards messages between a client and the executor process.

    Parameters
    ----------
    client : RobotClient
        Client of the robot.
    sensors : collection of str
        Topics that the client publishes and the nodes receive directly.
    latch : OnboardLatch
        Holds the velocities of the nodes while the robot is stopped.
    """

    def __init__(self, client: RobotClient, sensors: Collection[str], latch: OnboardLatch) -> None:
        self._client = client
        self._latch = latch
        self._sensors = frozenset(sensors)
        self._process: NodeProcess | None = None
        self._subscribes: dict[str, set[str]] = {}
        self._kinds: dict[str, type[Message]] = {}
        self._publishes: dict[str, set[str]] = {}
        self._subscriptions: dict[str, TopicSubscription[Message]] = {}
        self._delivering = ""
        self._waiting: deque[tuple[str, Message]] = deque(maxlen=MAX_WAITING)
        self._heard: dict[str, deque[str]] = {}
        self._arrived = asyncio.Event()

    # -- adding and removing nodes -------------------------------------------------------------------------------------

    def expect(self, node: str) -> None:
        """Start recording the messages that reach a node; call this when the node is added to the process."""
        self._heard[node] = deque(maxlen=MAX_HEARD)

    async def open(self, added: protocol.Added, process: NodeProcess) -> None:
        """Start forwarding the topics of a node.

        Raises
        ------
        PPaaSError
            The client has failed.
        """
        self._process = process
        self._publishes[added.node] = set(added.publishes)
        self._subscribes[added.node] = {topic.name for topic in added.subscribes}
        self._kinds |= {topic.name: message_type(topic.type) for topic in added.subscribes}
        for topic in added.subscribes:
            if topic.name not in self._subscriptions and topic.name not in self._sensors:
                self._subscriptions[topic.name] = await self._subscribe(topic)

    async def _subscribe(self, topic: protocol.TopicName) -> TopicSubscription[Message]:
        def forward(message: Message) -> None:
            if self._process is not None and self._delivering != topic.name:
                self._process.tell(topic.name, encode(message))
                self._record(topic.name, message)

        return await self._client.subscribe(topic.name, message_type(topic.type), forward)

    async def close(self, node: str) -> None:
        """Stop forwarding the topics that only this node used."""
        self._heard.pop(node, None)
        self._publishes.pop(node, None)
        self._subscribes.pop(node, None)
        wanted = {topic for topics in self._subscribes.values() for topic in topics}
        for topic in self._subscriptions.keys() - wanted:
            await self._client.unsubscribe(self._subscriptions.pop(topic))

    # -- messages of the client ----------------------------------------------------------------------------------------

    def published(self, topic: str, message: Message) -> bool:
        """Forward a message that the client publishes; return whether it must go to the cloud as well."""
        if topic not in self._sensors or self._process is None:
            return True
        if not any(topic in names for names in self._subscribes.values()):
            return True
        self._process.tell(topic, encode(message))
        return not policy_of(topic).local

    def owns(self, topic: str) -> bool:
        """Return whether local nodes are the only publishers of a topic; the cloud's messages are then echoes."""
        return not policy_of(topic).many_publishers and any(topic in names for names in self._publishes.values())

    # -- messages of the nodes -----------------------------------------------------------------------------------------

    def on_message(self, said: protocol.Said) -> None:
        """Deliver a message of a node to the client's subscriptions at once, and queue it for the cloud."""
        payload = self._latch.passed(said.topic, said.payload)
        message = decode(message_type(said.kind), payload)
        self._delivering = said.topic
        try:
            self._client.deliver(said.topic, payload)
        finally:
            self._delivering = ""
        self._record(said.topic, message)
        self._waiting.append((said.topic, message))
        self._arrived.set()

    # -- guaranteed messages -------------------------------------------------------------------------------------------

    def _record(self, topic: str, message: Message) -> None:
        if not policy_of(topic).stream:
            mark = fingerprint(topic, message)
            for heard in self._heard.values():
                heard.append(mark)

    def heard(self, node: str) -> list[str]:
        """Return the fingerprints of the guaranteed messages that a node has received since it was added."""
        return list(self._heard.get(node, ()))

    def deliver_missed(self, node: str, messages: Sequence[TopicMessage], process: NodeProcess) -> None:
        """Send a node the messages that arrived for it in the cloud and have not reached it."""
        for missed in messages:
            kind = self._kinds.get(missed.topic)
            if kind is None:
                continue
            message = decode(kind, missed.message.encode())
            mark = fingerprint(missed.topic, message)
            if mark not in self._heard[node]:
                process.tell(missed.topic, encode(message), node)
                self._heard[node].append(mark)

    async def run(self) -> None:
        """Publish the messages of the nodes to the cloud until cancelled.

        Raises
        ------
        PPaaSError
            The client has failed.
        """
        while True:
            await self._arrived.wait()
            self._arrived.clear()
            while self._waiting:
                topic, message = self._waiting.popleft()
                await self._client.publish(topic, message, newest_only=policy_of(topic).stream)


# -- services of local nodes, advertised by the robot's client while the nodes run on the robot ------------------------


class NodeServices:
    """Advertises the services of local nodes and forwards the calls to the executor process.

    In the cloud, a service of the clone takes precedence over one of a client. A node that continues there therefore
    serves at once, even before the robot has withdrawn the service.

    Parameters
    ----------
    client : RobotClient
        Client of the robot.
    """

    def __init__(self, client: RobotClient) -> None:
        self._client = client
        self._advertised: dict[str, list[str]] = {}

    async def open(self, added: protocol.Added, process: NodeProcess) -> None:
        """Advertise the services of a node.

        Raises
        ------
        PPaaSError
            The client has failed.
        """
        self._advertised[added.node] = []
        for service in added.services:
            kind = service_type(service.type)
            try:
                await self._client.advertise_service(service.name, kind, _forwarding(process, service.name, kind))
            except Conflict as error:  # the robot advertises a service of this name itself
                logger.warning("a service of %s is not available on the robot: %s", added.node, error)
            else:
                self._advertised[added.node].append(service.name)

    async def close(self, node: str) -> None:
        """Withdraw the services of a node.

        Raises
        ------
        PPaaSError
            The client has failed.
        """
        for service in self._advertised.pop(node, ()):
            await self._client.unadvertise_service(service)


def _forwarding(process: NodeProcess, service: str, kind: ServiceType) -> Handler:
    async def answer(request: Message) -> Message:
        return decode(kind.response, await process.call(service, encode(request)))

    return answer
