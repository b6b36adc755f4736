"""Master control of one AGV, which checks all that it hears against the published schemas."""

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from typing import Any

from aiomqtt import Client

from ppaas.clock import epoch
from ppaas.geometry import Pose2D
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import decode, encode
from ppaas.wire.vda5050.fields import Fields
from ppaas.wire.vda5050.headers import HeaderCounter
from ppaas.wire.vda5050.orders import Action, ActionParameter, Edge, InstantActions, Node, NodePosition, Order
from ppaas.wire.vda5050.topics import AgvAddress, Version
from tests.support.vda5050.mosquitto import Mosquitto
from tests.support.vda5050.schemas import problems


class Master:
    """Master control of one AGV: keeps what it hears."""

    def __init__(self, client: Client, version: Version, serial: str) -> None:
        self._client, self._version = client, version
        self._address = AgvAddress.of(version, "ppaas", serial)
        self._headers = HeaderCounter(version, self._address)
        self.heard: dict[str, list[Any]] = {name: [] for name in topics.FROM_AGV}
        self.problems: list[str] = []
        self._changed = asyncio.Event()

    async def listen(self) -> None:
        await self._client.subscribe(self._address.topic("+"), qos=1)
        async for message in self._client.messages:
            name = message.topic.value.rpartition("/")[2]
            if name in self.heard and isinstance(message.payload, bytes):
                self.problems += problems(self._version, name, message.payload)
                self.heard[name].append(decode(name, message.payload, self._version)[1])
                self._changed.set()

    async def send(self, name: str, body: Fields, *, times: int = 1, retain: bool = False) -> None:
        payload = encode(name, self._headers.next(name, epoch()), body, self._version)
        for _ in range(times):
            await self._client.publish(self._address.topic(name), payload, qos=1, retain=retain)

    async def send_raw(self, name: str, payload: bytes) -> None:
        await self._client.publish(self._address.topic(name), payload, qos=1)

    async def act(self, kind: str, action_id: str, **parameters: object) -> None:
        made = [ActionParameter(key=key, value=value) for key, value in parameters.items()]
        action = Action(action_type=kind, action_id=action_id, blocking_type="NONE", action_parameters=made)
        await self.send(topics.INSTANT_ACTIONS, InstantActions(actions=[action]))

    async def until(self, name: str, wanted: Callable[[Any], bool], timeout: float = 40.0) -> Any:
        """Wait for a message of a topic, from the newest on, and return it."""
        seen = max(len(self.heard[name]) - 1, 0)
        try:
            async with asyncio.timeout(timeout):
                while True:
                    for message in self.heard[name][seen:]:
                        if wanted(message):
                            return message
                    seen = len(self.heard[name])
                    self._changed.clear()
                    await self._changed.wait()
        except TimeoutError:
            raise AssertionError(f"no such {name}; the last one is {self.heard[name][-1:]}") from None


@asynccontextmanager
async def commanding(broker: Mosquitto, version: Version, serial: str) -> AsyncIterator[Master]:
    """Connect a master control."""
    async with Client("127.0.0.1", broker.port) as client:
        master = Master(client, version, serial)
        listening = asyncio.create_task(master.listen())
        try:
            yield master
        finally:
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)


def route(places: Sequence[Pose2D], base: int, *, update: int = 0, first: int = 0, order_id: str = "o1") -> Order:
    """Return an order along places, of which those up to ``base`` are released."""
    positions = [NodePosition(x=place.x, y=place.y, map_id="office") for place in places]
    numbers = range(first, first + len(places))
    nodes = [
        Node(node_id=f"n{n}", sequence_id=2 * n, released=n <= base, actions=[], node_position=position)
        for n, position in zip(numbers, positions, strict=True)
    ]
    edges = [
        Edge(
            edge_id=f"e{n}",
            sequence_id=2 * n + 1,
            released=n < base,
            actions=[],
            start_node_id=f"n{n}",
            end_node_id=f"n{n + 1}",
        )
        for n in numbers[:-1]
    ]
    return Order(order_id=order_id, order_update_id=update, nodes=nodes, edges=edges)
