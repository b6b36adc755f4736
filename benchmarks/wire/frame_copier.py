"""Baseline: a bare program of uvicorn and websockets that copies each frame of a WebSocket to a Unix socket.

``python -m benchmarks.wire.frame_copier PATH`` prints its port and runs until its input ends; each WebSocket has a
connection to the Unix socket at the path.
"""

import asyncio
import socket
import sys
from typing import Any

import uvicorn
import uvloop

HOST = "127.0.0.1"
LENGTH = 4
"""Size of the length before each frame [bytes], as in the framing of the cloud."""


class FrameCopier:
    """ASGI application that copies frames.

    Parameters
    ----------
    path : str
        Path of the Unix socket.
    """

    def __init__(self, path: str) -> None:
        self._path = path

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Serve a WebSocket."""
        await receive()
        await send({"type": "websocket.accept"})
        _, writer = await asyncio.open_unix_connection(self._path)
        while (message := await receive())["type"] == "websocket.receive":
            frame = message["text"].encode()
            writer.write(len(frame).to_bytes(LENGTH, "big") + frame)
        writer.close()


async def _serve(path: str) -> None:
    listener = socket.create_server((HOST, 0), backlog=2048)
    config = uvicorn.Config(FrameCopier(path), log_level="error", lifespan="off", ws_per_message_deflate=False)
    server = uvicorn.Server(config)
    sys.stdout.write(f"{listener.getsockname()[1]}\n")
    sys.stdout.flush()
    serving = asyncio.create_task(server.serve([listener]))
    await asyncio.to_thread(sys.stdin.read)
    server.should_exit = True
    await serving


def main() -> int:
    """Run until standard input is closed."""
    uvloop.run(_serve(sys.argv[1]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
