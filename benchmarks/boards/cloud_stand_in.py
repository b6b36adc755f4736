"""Stand-in for a cloud: it notes when the scans of a board arrive, and sends it velocities and a map."""

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from ppaas.clock import monotonic
from ppaas.messages.codec import encode
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.wire.binary.compact import SCAN, compact_cmd_vel

COMMAND_PERIOD = 0.05
"""Interval of velocities [s]."""

CELLS = 240 * 240
"""Size of the map, which the board must pass over, once a second."""


class BoardCloud:
    """Server for one board.

    Attributes
    ----------
    port : int
    scans : list of float
        Times at which scans arrived [s].
    """

    def __init__(self) -> None:
        self.port = 0
        self.scans: list[float] = []

    async def serve(self, socket: ServerConnection) -> None:
        """Serve the board until it leaves."""
        commands = asyncio.create_task(self._command(socket))
        try:
            with contextlib.suppress(ConnectionClosed):  # a board that leaves does not wait for an answer
                async for frame in socket:
                    if isinstance(frame, bytes) and frame[0] == SCAN:
                        self.scans.append(monotonic())
        finally:
            commands.cancel()
            await asyncio.gather(commands, return_exceptions=True)

    @staticmethod
    async def _command(socket: ServerConnection) -> None:
        velocity = bytes(compact_cmd_vel(encode(Twist(Vector3(0.2), Vector3(z=0.1)))))
        grid = json.dumps({"op": "publish", "topic": "map", "msg": {"data": [0] * CELLS}})
        pose = json.dumps({"op": "publish", "topic": "amcl_pose", "msg": {"x": 1.0}})
        tick = 0
        while True:
            await socket.send(velocity)
            if tick % 20 == 0:
                await socket.send(grid)
                await socket.send(pose)
            tick += 1
            await asyncio.sleep(COMMAND_PERIOD)


@asynccontextmanager
async def board_cloud() -> AsyncIterator[BoardCloud]:
    """Run a stand-in on a free port of the loopback interface."""
    cloud = BoardCloud()
    async with serve(cloud.serve, "127.0.0.1", 0, compression=None) as server:
        cloud.port = server.sockets[0].getsockname()[1]
        yield cloud
