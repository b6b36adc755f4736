"""Uvicorn server on a real socket."""

import asyncio
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import uvicorn
from starlette.types import ASGIApp

from endpoints.http.websocket_protocol import DirectWebSocket


@asynccontextmanager
async def serve(app: ASGIApp, **options: Any) -> AsyncIterator[int]:
    """Serve an application on a free port of the loopback interface, with options of uvicorn; yield the port."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        # asyncio sets it for its own listeners only: else the body of an answer waits 40 ms for the ACK of its head.
        listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        server = uvicorn.Server(
            uvicorn.Config(
                app, ws=DirectWebSocket, log_level="warning", lifespan="off", timeout_graceful_shutdown=5, **options
            )
        )
        # The socket already listens, so early clients wait to be accepted.
        task = asyncio.create_task(server.serve(sockets=[listener]))
        try:
            yield listener.getsockname()[1]
        finally:
            server.should_exit = True
            await task
