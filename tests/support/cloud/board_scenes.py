"""Server that plays the cloud for clients of boards, scene by scene."""

import asyncio
import json
import struct
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from http import HTTPStatus
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.http11 import Request, Response

from ppaas.wire.binary.packing import operation_of

CMD_VEL = struct.pack("<BBHI3f", 3, 0, 3, 0, 0.25, 0.0, -0.5)

Play = Callable[[ServerConnection], Coroutine[Any, Any, None]]


class Cloud:
    """Server that plays one scene after the other, one for each connection."""

    def __init__(self, *scenes: Play) -> None:
        self._scenes = list(scenes)
        self.paths: list[str] = []
        self.port = 0

    async def serve(self, socket: ServerConnection) -> None:
        assert socket.request is not None
        self.paths.append(socket.request.path)
        assert socket.request.headers["Authorization"] == "Bearer t0ken"
        await self._scenes.pop(0)(socket)

    @staticmethod
    def greet(_socket: ServerConnection, request: Request, response: Response) -> Response:
        response.headers["PPaaS-Session"] = "new" if "resume=none" in request.path else "resumed"
        response.headers["PPaaS-Session-Id"] = "abc"
        return response


@asynccontextmanager
async def playing(*scenes: Play, **options: Any) -> AsyncIterator[Cloud]:
    cloud = Cloud(*scenes)
    async with serve(cloud.serve, "127.0.0.1", 0, process_response=cloud.greet, **options) as server:
        cloud.port = next(iter(server.sockets)).getsockname()[1]
        yield cloud


def published(topic: str, message: Any) -> str:
    return json.dumps({"op": "publish", "topic": topic, "msg": message})


async def receive_until(socket: ServerConnection, count: int) -> list[Any]:
    """Return the operations of the next frames."""
    frames = [await socket.recv() for _ in range(count)]
    return [json.loads(frame if isinstance(frame, str) else operation_of(frame)) for frame in frames]


async def move_container(socket: ServerConnection) -> None:
    """Play a cloud that sends two messages, one of them large, and then moves the container of the robot."""
    await receive_until(socket, 2)
    await socket.send(CMD_VEL)
    await socket.send(published("map", {"data": [0] * 1000}))
    await asyncio.sleep(0.2)
    await socket.close(1011, "unavailable: the container moves")


async def drive_on(socket: ServerConnection) -> None:
    """Play a cloud that sends one velocity."""
    await socket.send(CMD_VEL)
    await socket.wait_closed()


def refuse_token(socket: ServerConnection, _request: Request) -> Response:
    """Refuse the handshake."""
    return socket.respond(HTTPStatus.UNAUTHORIZED, "the token is unknown")
