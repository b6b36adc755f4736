"""Baselines of the network: servers that answer each request with prepared bytes.

They run on uvloop, as a cloud does: asyncio's own loop would delay the second packet of an answer by 40 ms.
``python -m benchmarks.service.echo_server websockets|fastapi BYTES`` prints its port and runs until its input ends.
"""

import asyncio
import socket
import sys
from typing import Any

import uvloop

HOST = "127.0.0.1"


def main() -> int:
    """Run one kind of server until standard input is closed."""
    kind, size = sys.argv[1], int(sys.argv[2])
    answer = "[" + "0.25," * (size // 5) + "0]"
    uvloop.run({"websockets": _websockets, "fastapi": _fastapi}[kind](answer))
    return 0


async def _hung_up() -> None:
    await asyncio.to_thread(sys.stdin.read)


def _tell_port(port: int) -> None:
    sys.stdout.write(f"{port}\n")
    sys.stdout.flush()


async def _websockets(answer: str) -> None:
    from websockets.asyncio.server import ServerConnection, serve  # noqa: PLC0415 - each kind has its own libraries

    async def echo(connection: ServerConnection) -> None:
        async for _ in connection:
            await connection.send(answer)

    async with serve(echo, HOST, 0, compression=None, max_size=None) as server:
        _tell_port(next(iter(server.sockets)).getsockname()[1])
        await _hung_up()


async def _fastapi(answer: str) -> None:
    import uvicorn  # noqa: PLC0415
    from fastapi import FastAPI, Request, Response, WebSocket, WebSocketDisconnect  # noqa: PLC0415

    app = FastAPI()

    @app.post("/")
    async def echo(request: Request) -> Response:
        await request.body()
        return Response(answer, media_type="application/json")

    @app.websocket("/")
    async def echo_socket(connection: WebSocket) -> None:
        await connection.accept()
        try:
            while await connection.receive_text():
                await connection.send_text(answer)
        except WebSocketDisconnect:
            return

    # The annotations of nested functions are looked up where FastAPI was imported.
    _: Any = echo, echo_socket
    listener = socket.create_server((HOST, 0))
    server = uvicorn.Server(uvicorn.Config(app, log_level="error", ws_per_message_deflate=False))
    _tell_port(listener.getsockname()[1])
    serving = asyncio.create_task(server.serve([listener]))
    await _hung_up()
    server.should_exit = True
    await serving


if __name__ == "__main__":
    sys.exit(main())
