"""Small rosbridge server for tests of clients: records received frames, sends frames on request."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from http import HTTPStatus
from typing import Any

from websockets.asyncio.server import Request, Response, ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed


class RosbridgeServer:
    """Server on one port with any number of connections."""

    def __init__(self) -> None:
        self.url = ""
        self.frames: list[dict[str, Any]] = []
        self.paths: list[str] = []
        self.received: list[Headers] = []
        self.headers: dict[str, str] = {}
        self.refusal: tuple[int, bytes] | None = None
        self.connections: list[ServerConnection] = []
        self.listening = asyncio.Event()
        self.listening.set()
        self._changed = asyncio.Condition()

    async def serve(self, connection: ServerConnection) -> None:
        self.connections.append(connection)
        await self._notify()
        with suppress(ConnectionClosed):
            while True:
                await self.listening.wait()
                self.frames.append(json.loads(await connection.recv()))
                await self._notify()

    def check(self, connection: ServerConnection, request: Request) -> Response | None:
        self.paths.append(request.path)
        self.received.append(request.headers)
        if self.refusal is None:
            return None
        status, body = self.refusal
        headers = Headers({"Content-Type": "application/problem+json", "Content-Length": str(len(body))})
        return Response(status, HTTPStatus(status).phrase, headers, body)

    def answer(self, connection: ServerConnection, request: Request, response: Response) -> None:
        response.headers.update(self.headers)

    async def _notify(self) -> None:
        async with self._changed:
            self._changed.notify_all()

    def of(self, op: str) -> list[dict[str, Any]]:
        return [frame for frame in self.frames if frame["op"] == op]

    async def heard(self, op: str, count: int = 1, timeout: float = 10.0) -> list[dict[str, Any]]:
        """Wait until ``count`` frames of an operation have been received."""
        async with asyncio.timeout(timeout), self._changed:
            await self._changed.wait_for(lambda: len(self.of(op)) >= count)
        return self.of(op)

    async def connected(self, count: int = 1, timeout: float = 10.0) -> ServerConnection:
        """Wait for the connection number ``count``, and return it."""
        async with asyncio.timeout(timeout), self._changed:
            await self._changed.wait_for(lambda: len(self.connections) >= count)
        return self.connections[count - 1]

    async def say(self, **frame: Any) -> None:
        """Send a frame on the newest connection."""
        await self.connections[-1].send(json.dumps(frame))


@asynccontextmanager
async def rosbridge_server(**options: Any) -> AsyncIterator[RosbridgeServer]:
    """Run a server on a free port of the loopback interface."""
    server = RosbridgeServer()
    hooks = {"process_request": server.check, "process_response": server.answer}
    async with serve(server.serve, "127.0.0.1", 0, **hooks, **options) as listening:
        server.url = f"http://127.0.0.1:{listening.sockets[0].getsockname()[1]}"
        yield server
