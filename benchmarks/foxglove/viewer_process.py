"""Process of a viewer: it subscribes to scans, transforms and poses of all robots, and counts what comes.

``python -m benchmarks.foxglove.viewer_process URL CHANNELS``; each line on standard input is a request: ``subscribe``,
or ``count``, which is answered with the number of messages since the last one.
"""

import asyncio
import sys

import msgspec
from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Subprotocol

from benchmarks.harness.json_process import lines, tell

TOPICS = ("scan", "tf", "amcl_pose")


class _Viewer:
    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket
        self.channels: dict[int, str] = {}
        self.counted = 0

    async def read(self) -> None:
        async for frame in self._socket:
            if isinstance(frame, bytes):
                self.counted += frame[0] == 1
                continue
            operation = msgspec.json.decode(frame)
            if operation["op"] == "advertise":
                wanted = (one for one in operation["channels"] if one["topic"].rpartition("/")[2] in TOPICS)
                self.channels |= {one["id"]: one["topic"] for one in wanted if one["topic"].count("/") == 2}

    async def subscribe(self) -> None:
        wanted = [{"id": channel, "channelId": channel} for channel in self.channels]
        await self._socket.send(msgspec.json.encode({"op": "subscribe", "subscriptions": wanted}).decode())


async def _run(url: str, channels: int) -> None:
    async with connect(url, subprotocols=[Subprotocol("foxglove.sdk.v1")], max_size=None, compression=None) as socket:
        viewer = _Viewer(socket)
        reading = asyncio.create_task(viewer.read())
        while len(viewer.channels) < channels:  # noqa: ASYNC110 - one wait before a measurement
            await asyncio.sleep(0.05)
        tell("ready")
        async for request in lines():
            if request == "subscribe":
                await viewer.subscribe()
            viewer.counted, counted = 0, viewer.counted
            tell(counted)
        reading.cancel()


if __name__ == "__main__":
    asyncio.run(_run(sys.argv[1], int(sys.argv[2])))
