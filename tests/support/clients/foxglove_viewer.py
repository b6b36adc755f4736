"""Viewer that speaks ``foxglove.sdk.v1``, and reads messages by the schemas that the server announces."""

import asyncio
import base64
import contextlib
import itertools
import json
import struct
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Subprotocol

SUBPROTOCOL = Subprotocol("foxglove.sdk.v1")
TIMEOUT = 20.0
"""Time limit of each step [s]."""


class FoxgloveViewer:
    """Viewer.

    Parameters
    ----------
    socket : ClientConnection

    Attributes
    ----------
    channels : dict
        Channels by id, as the server announced them.
    """

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket
        self.channels: dict[int, dict[str, Any]] = {}
        self._numbers = itertools.count(1)

    async def send(self, operation: dict[str, Any]) -> None:
        """Send an operation."""
        await self._socket.send(json.dumps(operation))

    async def receive(self) -> dict[str, Any] | bytes:
        """Return the next operation or binary frame; note the channels that it opens or closes."""
        async with asyncio.timeout(TIMEOUT):
            frame = await self._socket.recv()
        if isinstance(frame, bytes):
            return frame
        operation: dict[str, Any] = json.loads(frame)
        for channel in operation["channels"] if operation["op"] == "advertise" else ():
            self.channels[channel["id"]] = channel
        for closed in operation["channelIds"] if operation["op"] == "unadvertise" else ():
            del self.channels[closed]
        return operation

    async def status(self) -> str:
        """Return the text of the next status."""
        while True:
            operation = await self.receive()
            if isinstance(operation, dict) and operation["op"] == "status":
                return str(operation["message"])

    async def until_channel(self, topic: str) -> dict[str, Any]:
        """Return the channel of a topic, once it is there."""
        while True:
            for channel in self.channels.values():
                if channel["topic"] == topic:
                    return channel
            await self.receive()

    async def message(self, topic: str) -> Any:
        """Subscribe to a topic, return its first message, read by its schema of protobuf, and unsubscribe."""
        channel, subscription = await self.until_channel(topic), next(self._numbers)
        await self.send({"op": "subscribe", "subscriptions": [{"id": subscription, "channelId": channel["id"]}]})
        while True:
            frame = await self.receive()
            if isinstance(frame, bytes) and frame[0] == 1 and struct.unpack_from("<I", frame, 1)[0] == subscription:
                break
        await self.send({"op": "unsubscribe", "subscriptionIds": [subscription]})
        return read_protobuf(channel, frame[13:])

    async def publish(self, topic: str, schema: str, values: dict[str, Any]) -> None:
        """Advertise a topic and publish a message as JSON."""
        channel = next(self._numbers)
        described = {"id": channel, "topic": topic, "encoding": "json", "schemaName": schema}
        await self.send({"op": "advertise", "channels": [described]})
        await self._socket.send(struct.pack("<BI", 1, channel) + json.dumps(values).encode())


def read_protobuf(channel: dict[str, Any], data: bytes) -> Any:
    """Return a message, read by the schema of its channel."""
    files = descriptor_pb2.FileDescriptorSet.FromString(base64.b64decode(channel["schema"]))
    pool = descriptor_pool.DescriptorPool()
    waiting = list(files.file)
    while waiting:
        file = waiting.pop(0)
        with contextlib.suppress(TypeError):  # a file that it imports comes later
            pool.Add(file)
            continue
        waiting.append(file)
    kind = message_factory.GetMessageClass(pool.FindMessageTypeByName(channel["schemaName"]))
    return kind.FromString(data)


@asynccontextmanager
async def viewer_of(url: str) -> AsyncIterator[FoxgloveViewer]:
    """Connect a viewer."""
    async with connect(url, subprotocols=[SUBPROTOCOL], max_size=None) as socket:
        assert socket.subprotocol == SUBPROTOCOL
        yield FoxgloveViewer(socket)
