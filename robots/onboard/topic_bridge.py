"""What local nodes hear and say: by the robot's own client, and over its WebSocket by the cloud."""

import asyncio
import logging
from collections import deque
from collections.abc import Collection, Sequence

from ppaas.messages import decode, encode, message_type
from ppaas.messages.message import Message
from ppaas.messages.ppaas_msgs import TopicMessage
from ppaas.nodes.message_fingerprint import fingerprint
from ppaas.nodes.topics import policy_of
from robots.client.robot_client import RobotClient
from robots.client.subscription import Subscription
from robots.onboard.executor import protocol
from robots.onboard.node_process import NodeProcess

logger = logging.getLogger(__name__)

MAX_WAITING = 1000
"""Messages that may wait while the link is down."""

MAX_HEARD = 100
"""Fingerprints of the last things that must arrive, and reached a node."""


class Crossing:
    """Carries messages between a client and the process of local nodes.

    Parameters
    ----------
    client : RobotClient
        Of the robot.
    sensors : collection of str
        Topics that the client publishes, and the nodes hear from here.
    """

    def __init__(self, client: RobotClient, sensors: Collection[str]) -> None:
        self._client = client
        self._sensors = frozenset(sensors)
        self._process: NodeProcess | None = None
        self._hears: dict[str, set[str]] = {}
        self._kinds: dict[str, type[Message]] = {}
        self._says: dict[str, set[str]] = {}
        self._subscriptions: dict[str, Subscription[Message]] = {}
        self._hearing = ""
        self._waiting: deque[tuple[str, Message]] = deque(maxlen=MAX_WAITING)
        self._heard: dict[str, deque[str]] = {}
        self._arrived = asyncio.Event()

    # -- nodes come and go ---------------------------------------------------------------------------------------------

    def expect(self, node: str) -> None:
        """Note from now on what reaches a node; to be called as it is put into the process."""
        self._heard[node] = deque(maxlen=MAX_HEARD)

    async def open(self, added: protocol.Added, process: NodeProcess) -> None:
        """Begin to carry what a node hears and says.

        Raises
        ------
        PPaaSError
            The client has given up.
        """
        self._process = process
        self._says[added.node] = set(added.publishes)
        self._hears[added.node] = {topic.name for topic in added.subscribes}
        self._kinds |= {topic.name: message_type(topic.type) for topic in added.subscribes}
        for topic in added.subscribes:
            if topic.name not in self._subscriptions and topic.name not in self._sensors:
                self._subscriptions[topic.name] = await self._subscribe(topic)

    async def _subscribe(self, topic: protocol.TopicName) -> Subscription[Message]:
        def tell(message: Message) -> None:
            if self._process is not None and self._hearing != topic.name:
                self._process.tell(topic.name, encode(message))
                self._note(topic.name, message)

        return await self._client.subscribe(topic.name, message_type(topic.type), tell)

    async def close(self, node: str) -> None:
        """Carry no more of what this node alone hears and says."""
        self._heard.pop(node, None)
        self._says.pop(node, None)
        self._hears.pop(node, None)
        wanted = {topic for topics in self._hears.values() for topic in topics}
        for topic in self._subscriptions.keys() - wanted:
            await self._client.unsubscribe(self._subscriptions.pop(topic))

    # -- from the client -----------------------------------------------------------------------------------------------

    def published(self, topic: str, message: Message) -> bool:
        """Take what the client publishes; tell whether the cloud has to hear it as well."""
        if topic in self._sensors and self._process is not None and self._hears:
            self._process.tell(topic, encode(message))
            return not policy_of(topic).local or not any(topic in hears for hears in self._hears.values())
        return True

    def owns(self, topic: str) -> bool:
        """Tell whether local nodes alone say things on a topic: what comes from the cloud is their echo."""
        return not policy_of(topic).many_publishers and any(topic in says for says in self._says.values())

    # -- from the nodes ------------------------------------------------------------------------------------------------

    def said(self, said: protocol.Said) -> None:
        """Take what a node says: whoever hears it here hears it at once, and the cloud is told."""
        message = decode(message_type(said.kind), said.payload)
        self._hearing = said.topic
        try:
            self._client.hear(said.topic, said.payload)
        finally:
            self._hearing = ""
        self._note(said.topic, message)
        self._waiting.append((said.topic, message))
        self._arrived.set()

    # -- what must arrive ----------------------------------------------------------------------------------------------

    def _note(self, topic: str, message: Message) -> None:
        if not policy_of(topic).stream:
            mark = fingerprint(topic, message)
            for heard in self._heard.values():
                heard.append(mark)

    def heard(self, node: str) -> list[str]:
        """Return the fingerprints of what must arrive, and has reached a node since it was put into the process."""
        return list(self._heard.get(node, ()))

    def tell_unheard(self, node: str, messages: Sequence[TopicMessage], process: NodeProcess) -> None:
        """Tell a node what came for it in the cloud, and has not reached it."""
        for came in messages:
            kind = self._kinds.get(came.topic)
            if kind is None:
                continue
            message = decode(kind, came.message.encode())
            mark = fingerprint(came.topic, message)
            if mark not in self._heard[node]:
                process.tell(came.topic, encode(message), node)
                self._heard[node].append(mark)

    async def run(self) -> None:
        """Tell the cloud what nodes say, until cancelled.

        Raises
        ------
        PPaaSError
            The client has given up.
        """
        while True:
            await self._arrived.wait()
            self._arrived.clear()
            while self._waiting:
                topic, message = self._waiting.popleft()
                await self._client.publish(topic, message, newest_only=policy_of(topic).stream)
