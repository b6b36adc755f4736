"""What local nodes hear and say: by the robot's own client, and over its WebSocket by the cloud."""

import asyncio
import logging
from collections import deque
from collections.abc import Collection

from ppaas.messages import decode, encode, message_type
from ppaas.messages.message import Message
from robots.client import RobotClient
from robots.local import frames
from robots.local.node_process import NodeProcess
from robots.subscription import Subscription

logger = logging.getLogger(__name__)

MUST_ARRIVE = ("/goal", "/cancel", "/result")
"""How the names of topics end on which no message makes up for another."""
MAX_WAITING = 1000
"""Messages that must arrive and may wait while the link is down."""


def has_many_speakers(topic: str) -> bool:
    """Tell whether others than the node say things on a topic, which it has to hear from the cloud."""
    return topic in ("tf", "tf_static") or topic.endswith(("/goal", "/cancel"))


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
        self._says: dict[str, set[str]] = {}
        self._subscriptions: dict[str, Subscription[Message]] = {}
        self._hearing = ""
        self._waiting: deque[tuple[str, Message]] = deque(maxlen=MAX_WAITING)
        self._unkept: deque[tuple[str, Message]] = deque(maxlen=MAX_WAITING)
        self._arrived = asyncio.Event()

    # -- nodes come and go ---------------------------------------------------------------------------------------------

    async def open(self, added: frames.Added, process: NodeProcess) -> None:
        """Begin to carry what a node hears and says.

        Raises
        ------
        PPaaSError
            The client has given up.
        """
        self._process = process
        self._says[added.node] = set(added.publishes)
        self._hears[added.node] = {topic.name for topic in added.subscribes}
        for topic in added.subscribes:
            if topic.name not in self._subscriptions and topic.name not in self._sensors:
                self._subscriptions[topic.name] = await self._subscribe(topic)

    async def _subscribe(self, topic: frames.TopicName) -> Subscription[Message]:
        def tell(message: Message) -> None:
            if self._process is not None and self._hearing != topic.name:
                self._process.tell(topic.name, encode(message))
                if topic.name.endswith(MUST_ARRIVE):
                    self._unkept.append((topic.name, message))

        return await self._client.subscribe(topic.name, message_type(topic.type), tell)

    async def close(self, node: str) -> None:
        """Carry no more of what this node alone hears and says."""
        self._says.pop(node, None)
        self._hears.pop(node, None)
        wanted = {topic for topics in self._hears.values() for topic in topics}
        for topic in self._subscriptions.keys() - wanted:
            await self._client.unsubscribe(self._subscriptions.pop(topic))

    # -- from the client -----------------------------------------------------------------------------------------------

    def published(self, topic: str, message: Message) -> None:
        """Take what the client publishes."""
        if topic in self._sensors and self._process is not None and self._hears:
            self._process.tell(topic, encode(message))

    def owns(self, topic: str) -> bool:
        """Tell whether local nodes alone say things on a topic: what comes from the cloud is their echo."""
        return not has_many_speakers(topic) and any(topic in says for says in self._says.values())

    # -- from the nodes ------------------------------------------------------------------------------------------------

    def said(self, said: frames.Said) -> None:
        """Take what a node says: whoever hears it here hears it at once, and the cloud is told."""
        message = decode(message_type(said.kind), said.payload)
        self._hearing = said.topic
        try:
            self._client.hear(said.topic, said.payload)
        finally:
            self._hearing = ""
        self._waiting.append((said.topic, message))
        self._arrived.set()

    # -- what a state that is known does not have in it ----------------------------------------------------------------

    @property
    def heard(self) -> int:
        """How many messages that must arrive nodes were told since the last state that has them in it."""
        return len(self._unkept)

    def kept(self, count: int) -> None:
        """Forget the first of these: a state that was asked for after them is known."""
        for _ in range(min(count, len(self._unkept))):
            self._unkept.popleft()

    def say_again(self) -> None:
        """Have the rest told to whoever goes on from the last state that is known."""
        self._waiting.extend(self._unkept)
        self._unkept.clear()
        self._arrived.set()

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
                await self._client.publish(topic, message, newest_only=not topic.endswith(MUST_ARRIVE))
