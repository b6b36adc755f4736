"""What a cloud shows on the web: the application, the sockets of robots, and the server of both."""

import contextlib
import socket
from collections.abc import Coroutine, Iterator
from typing import Any

import uvicorn
from fastapi import FastAPI
from starlette.routing import WebSocketRoute
from starlette.websockets import WebSocket

from endpoints.accounts.accounts import Accounts
from endpoints.app import create_app
from endpoints.http.http_protocol import DirectHttp
from endpoints.http.websocket_protocol import DirectWebSocket
from endpoints.rosbridge.idle_watch import IdleWatch
from endpoints.rosbridge.robot_socket import serve_robot_socket
from endpoints.rosbridge.session_registry import SessionRegistry
from endpoints.services.services import Services
from engine.bootstrap import Engine
from engine.processes.background import Background

MAX_FRAME = 16 * 1024 * 1024
"""Bytes of one frame of a robot: ten times a raw 640×480 depth image."""


class Server(uvicorn.Server):
    """Leaves signals to us, so that the cloud ends before the process does."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Capture none."""
        yield


class Web:
    """Serves a cloud.

    Parameters
    ----------
    engine : Engine
        Which is closed after this, by whoever made it.
    linger : float
        Seconds that a session is kept without a socket.
    idle : float
        Seconds of silence after which a robot is let go; 0 lets nobody go.
    dead : float
        Seconds after which a silent connection counts as dead.
    log_level : str
        ``error`` for errors alone.
    """

    def __init__(self, engine: Engine, *, linger: float, idle: float, dead: float, log_level: str) -> None:
        self.accounts = Accounts(engine.store)
        self._sessions = SessionRegistry(engine.sessions, engine.cloud.plan_rate, linger)
        self._idle = IdleWatch(self._sessions, engine.sessions, idle)
        self._watching = Background()
        services = Services(engine.store, engine.map_store, self.accounts, engine.cloud)
        self._server = Server(_uvicorn_config(build_app(services, self._sessions), log_level, dead))

    async def serve(self, listener: socket.socket) -> None:
        """Serve until told to stop."""
        self._watching.run(self._idle.run())
        await self._server.serve([listener])

    def meanwhile(self, work: Coroutine[Any, Any, None]) -> None:
        """Have something done beside serving; it is given up at the end."""
        self._watching.run(work)

    def stop(self) -> None:
        """Let ``serve`` come to its end."""
        self._server.should_exit = True

    async def close(self) -> None:
        """End all sessions."""
        await self._watching.cancel()
        self._sessions.close()


def build_app(services: Services, sessions: SessionRegistry) -> FastAPI:
    """Return the web application."""
    app = create_app(services)

    async def robot_socket(websocket: WebSocket) -> None:
        await serve_robot_socket(websocket, services, sessions)

    app.router.routes.append(WebSocketRoute("/", robot_socket))
    return app


def _uvicorn_config(app: FastAPI, log_level: str, dead: float) -> uvicorn.Config:
    return uvicorn.Config(
        app,
        log_level="error" if log_level == "error" else "warning",  # at "info" it tells of each query
        log_config=None,
        access_log=False,  # a token may stand in the query
        proxy_headers=False,  # nothing asks where a client is, and each layer costs every request
        server_header=False,
        date_header=False,
        http=DirectHttp,
        ws_max_size=MAX_FRAME,
        ws=DirectWebSocket,
        ws_per_message_deflate=False,
        ws_ping_interval=dead / 3.0,  # a socket that dies right after a pong is noticed after both together
        ws_ping_timeout=dead * 2.0 / 3.0,
        timeout_graceful_shutdown=2,
    )
