"""Stand-in for a cloud: a rosbridge server that takes the messages of a bridge and notes when they arrived."""

import asyncio
from collections import defaultdict
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import msgspec
from websockets.asyncio.server import ServerConnection, serve

from ppaas.clock import monotonic

TOPICS = ["/odom", "/scan", "/tf", "/tf_static", "/goal_pose", "/initialpose"]
"""Topics that the stand-in's clone has."""


class _Frame(msgspec.Struct):
    op: str
    id: str | None = None
    topic: str = ""
    service: str = ""


class CloudStandIn:
    """Server for one bridge.

    Attributes
    ----------
    arrived : dict
        Times at which messages arrived, by topic [s].
    """

    def __init__(self) -> None:
        self.url = ""
        self.arrived: defaultdict[str, list[float]] = defaultdict(list)
        self.subscribed: set[str] = set()
        self._socket: ServerConnection | None = None
        self._decoder = msgspec.json.Decoder(_Frame)

    async def handle(self, socket: ServerConnection) -> None:
        """Serve a bridge."""
        self._socket = socket
        async for text in socket:
            now = monotonic()
            frame = self._decoder.decode(text)
            if frame.op == "publish":
                self.arrived[frame.topic].append(now)
            elif frame.op == "subscribe":
                self.subscribed.add(frame.topic)
            elif frame.op == "call_service":
                values = {"topics": TOPICS, "types": []}
                await self.send(op="service_response", service=frame.service, id=frame.id, result=True, values=values)

    async def send(self, **frame: Any) -> None:
        """Send a frame to the bridge."""
        assert self._socket is not None
        await self._socket.send(msgspec.json.encode(frame).decode())

    async def publish(self, topic: str, message: Any) -> None:
        """Publish a message once the bridge has subscribed to the topic."""
        async with asyncio.timeout(20.0):
            while topic not in self.subscribed:  # noqa: ASYNC110 - one wait before a measurement
                await asyncio.sleep(0.01)
        await self.send(op="publish", topic=topic, msg=message)


@asynccontextmanager
async def cloud_stand_in() -> AsyncIterator[CloudStandIn]:
    """Run a stand-in on a free port of the loopback interface."""
    cloud = CloudStandIn()
    async with serve(cloud.handle, "127.0.0.1", 0, compression=None, max_size=None) as server:
        cloud.url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
        yield cloud
