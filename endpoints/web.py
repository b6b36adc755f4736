"""Web server of a cloud: the REST application and the robot WebSocket."""

import asyncio
import contextlib
import socket
from collections.abc import Coroutine, Iterator, Sequence
from functools import partial
from typing import Any, cast

import uvicorn
from fastapi import FastAPI
from starlette.routing import WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.usage import Usage
from endpoints.accounts.user_turns import LocalTurns
from endpoints.app import create_app
from endpoints.audit.event import AuditLog
from endpoints.http.connection_table import ConnectionTable
from endpoints.http.front_settings import FrontSettings
from endpoints.http.http_protocol import DirectHttp, http_protocol
from endpoints.http.tls import ServerTls
from endpoints.http.tls_handshake import TlsListener
from endpoints.http.websocket_protocol import DirectWebSocket
from endpoints.merging.coordinator import JointMapCoordinator
from endpoints.people.counting import PeopleCounting
from endpoints.proposals.change_watch import ChangeWatch
from endpoints.rapyuta.app import rapyuta_app
from endpoints.rapyuta.registry import RobotRegistry
from endpoints.rosbridge.idle_watch import IdleWatch
from endpoints.rosbridge.rights_watch import RightsWatch
from endpoints.rosbridge.robot_socket import serve_robot_socket
from endpoints.rosbridge.session_registry import SessionRegistry
from endpoints.services.disk_watch import DiskWatch
from endpoints.services.services import Services
from engine.bootstrap import Engine
from engine.processes.background import Background

MAX_FRAME = 16 * 1024 * 1024
"""Largest frame of a robot [bytes]: ten times a raw 640×480 depth image."""

MAX_VIEWER_FRAME = 1024 * 1024
"""Largest frame of a viewer of Foxglove [bytes], which publishes goals, not sensors."""


class Server(uvicorn.Server):
    """Uvicorn server that leaves signals to the process, which closes the cloud first."""

    def __init__(self, config: uvicorn.Config) -> None:
        super().__init__(config)
        self._accepting = Background()

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Install no signal handlers."""
        yield

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start to accept connections; by TLS, with limits before the handshake is complete, which uvicorn lacks."""
        context = self.config.ssl
        await super().startup(sockets if context is None else [])
        if context is not None:
            kind = cast(type[DirectHttp], self.config.http_protocol_class)
            protocol = partial(kind, self.config, self.server_state, self.lifespan.state)
            for each in sockets or []:
                self._accepting.run(TlsListener(each, context, kind.table, protocol).run())

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Accept no further connections, and end all."""
        await self._accepting.cancel()
        await super().shutdown(sockets)


class Web:
    """Web server of one cloud.

    Parameters
    ----------
    engine : Engine
        Engine of the cloud; the caller closes it after the web server.
    linger : float
        Time for which a session is retained without a socket [s].
    idle : float
        Time without frames after which a robot is disconnected [s]; 0 disables this.
    dead : float
        Time after which a silent connection counts as dead [s].
    log_level : str
        ``error`` to log errors only.
    connections : ConnectionTable
        Table of the connections, with their limits.
    settings : FrontSettings
        Path prefix, trusted proxies and allowed origins.
    audit : AuditLog
        Audit log; the caller closes it.
    tls : ServerTls, optional
        Certificate of the server; without it, it serves HTTP.
    """

    def __init__(
        self,
        engine: Engine,
        *,
        linger: float,
        idle: float,
        dead: float,
        log_level: str,
        connections: ConnectionTable,
        settings: FrontSettings,
        audit: AuditLog,
        tls: ServerTls | None = None,
    ) -> None:
        turns = LocalTurns()
        self.accounts = Accounts(engine.store, turns=turns)
        self._sessions = SessionRegistry(engine.sessions, engine.cloud.plan_rate, linger)
        self._idle = IdleWatch(self._sessions, engine.sessions, idle)
        self._background = Background()
        services = self._services = Services(
            engine.store,
            engine.map_store,
            self.accounts,
            engine.cloud,
            usage=Usage(turns),
            disk=engine.reserve,
            recordings=engine.recordings,
            keep_versions=engine.keep_versions,
            audit=audit,
        )
        self._joint_maps = JointMapCoordinator(services)
        self._disk = DiskWatch.of(engine.reserve, engine.store)
        self._changes = ChangeWatch(services)
        self._people = PeopleCounting(services)
        self._rights = RightsWatch(self._sessions, engine.sessions, services)
        self._tls = tls
        self._settings = settings
        self._configured = partial(_uvicorn_config, log_level=log_level, dead=dead, connections=connections, tls=tls)
        self._server = Server(self._configured(build_app(services, self._sessions, settings)))
        self._rapyuta = RobotRegistry(services, self._sessions)
        self._others: list[tuple[Server, Sequence[socket.socket]]] = []

    async def serve(self, listeners: Sequence[socket.socket]) -> None:
        """Serve until `stop` is called."""
        self._background.run(self._idle.run())
        self._background.run(self._rights.run())
        self._background.run(self._disk.run())
        self._background.run(self._changes.run())
        self._background.run(self._people.run())
        self._background.run(self._joint_maps.run())
        if self._tls is not None:
            self._background.run(self._tls.watch())
        servers = [(self._server, listeners), *self._others]
        await asyncio.gather(*(server.serve(list(sockets)) for server, sockets in servers))

    def serve_rapyuta(self, listeners: Sequence[socket.socket]) -> None:
        """Let ``serve`` also serve robots of Rapyuta, on these listeners."""
        self._background.run(self._rapyuta.watch())
        app = rapyuta_app(self._services, self._rapyuta, self._settings)
        self._others.append((Server(self._configured(app)), listeners))

    def serve_foxglove(self, listeners: Sequence[socket.socket]) -> None:
        """Let ``serve`` also serve viewers of Foxglove, on these listeners; needs the extra ``foxglove``."""
        from endpoints.foxglove.app import foxglove_app  # noqa: PLC0415 - of the extra

        app = foxglove_app(self._services, self._sessions, self._settings)
        self._others.append((Server(self._configured(app, max_frame=MAX_VIEWER_FRAME)), listeners))

    def run_in_background(self, work: Coroutine[Any, Any, None]) -> None:
        """Run a coroutine in the background; it is cancelled at the end."""
        self._background.run(work)

    def stop(self) -> None:
        """Make ``serve`` return."""
        for server in (self._server, *(other for other, _ in self._others)):
            server.should_exit = True

    async def close(self) -> None:
        """End all sessions."""
        await self._background.cancel()
        await self._rapyuta.close()


def build_app(services: Services, sessions: SessionRegistry, settings: FrontSettings) -> FastAPI:
    """Return the application with REST and the robot WebSocket."""
    app = create_app(services, settings)

    async def robot_socket(websocket: WebSocket) -> None:
        await serve_robot_socket(websocket, services, sessions)

    app.router.routes.append(WebSocketRoute("/", robot_socket))
    return app


def _uvicorn_config(
    app: ASGIApp,
    log_level: str,
    dead: float,
    connections: ConnectionTable,
    tls: ServerTls | None,
    *,
    max_frame: int = MAX_FRAME,
) -> uvicorn.Config:
    return uvicorn.Config(
        app,
        log_level="error" if log_level == "error" else "warning",  # "info" logs each request
        log_config=None,
        access_log=False,  # the query may contain a token
        proxy_headers=False,  # endpoints.http.front does this, for trusted proxies
        server_header=False,
        date_header=False,
        http=http_protocol(connections),
        ws_max_size=max_frame,
        ws=DirectWebSocket,
        ws_per_message_deflate=False,
        ws_ping_interval=dead
        / 3.0,  # interval and timeout add up to the worst case, a peer that dies right after a pong
        ws_ping_timeout=dead * 2.0 / 3.0,
        timeout_graceful_shutdown=2,
        ssl_context_factory=None if tls is None else lambda *_: tls.context,
    )
