"""Web server of an endpoint: the REST application and the robot WebSocket."""

import asyncio
import contextlib
import logging
import socket
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import cast

import uvicorn
from starlette.routing import WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket

from endpoints.app import Application, create_app
from endpoints.http.connection_table import ConnectionTable
from endpoints.http.counted_requests import CountedRequests
from endpoints.http.front import ApplicationFront
from endpoints.http.front_settings import FrontSettings
from endpoints.http.http_protocol import DirectHttp, http_protocol
from endpoints.http.tls import HandshakeListener, ServerTls
from endpoints.http.websocket_protocol import DirectWebSocket
from endpoints.protocols import MAX_FRAME, PROTOCOLS, ClientProtocol
from endpoints.resources.services import Services
from endpoints.rosbridge import RightsWatch, RobotPlaces, SessionRegistry, serve_robot_socket
from engine.processes.background import Background


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
                self._accepting.run(HandshakeListener(each, context, kind.table, protocol).run())

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Accept no further connections, and end all."""
        await self._accepting.cancel()
        await super().shutdown(sockets)


class Web:
    """Web server of one endpoint.

    Parameters
    ----------
    services : Services
        Services of the application; the caller closes them.
    places : RobotPlaces
        Places of robots.
    linger : float
        Time for which a session is retained without a socket [s].
    dead : float
        Time after which a silent connection counts as dead [s].
    log_level : str
        ``error`` to log errors only.
    connections : ConnectionTable
        Table of the connections, with their limits.
    settings : FrontSettings
        Path prefix, trusted proxies and allowed origins.
    tls : ServerTls, optional
        Certificate of the server; without it, it serves HTTP.

    Attributes
    ----------
    services : Services
        As given.
    connections : ConnectionTable
        As given.
    sessions : SessionRegistry
        Sockets of robots and operators.
    requests : CountedRequests
        Requests that were answered.
    """

    def __init__(
        self,
        services: Services,
        places: RobotPlaces,
        *,
        linger: float,
        dead: float,
        log_level: str,
        connections: ConnectionTable,
        settings: FrontSettings,
        tls: ServerTls | None = None,
    ) -> None:
        self.services = services
        self.connections = connections
        self.sessions = SessionRegistry(places, services.cloud.count_paths, linger, lambda: services.cloud.start)
        self._background = Background()
        self._rights = RightsWatch(self.sessions, services)
        self._tls = tls
        self._settings = settings
        self._configured = partial(_uvicorn_config, log_level=log_level, dead=dead, connections=connections, tls=tls)
        app = build_app(services, self.sessions, settings)
        self._fronts = [app.front]
        self.requests = CountedRequests(app)
        self._server = Server(self._configured(self.requests))
        self._protocols: list[ClientProtocol] = []
        self._others: list[tuple[Server, Sequence[socket.socket]]] = []

    async def serve(self, listeners: Sequence[socket.socket]) -> None:
        """Serve until `stop` is called."""
        self._background.run(self._rights.run())
        if self._tls is not None:
            self._background.run(self._tls.watch())
        servers = [(self._server, listeners), *self._others]
        await asyncio.gather(*(server.serve(list(sockets)) for server, sockets in servers))

    def serve_protocol(self, name: str, listeners: Sequence[socket.socket]) -> None:
        """Load a protocol by its name, and make ``serve`` also serve its clients, on these listeners."""
        protocol = PROTOCOLS.load(name)(self.services, self.sessions, self._settings)
        self._protocols.append(protocol)
        self._background.run(protocol.watch())
        app = protocol.app()
        if isinstance(app, ApplicationFront):
            self._fronts.append(app)
        server = Server(self._configured(app, max_frame=protocol.max_frame))
        self._others.append((server, listeners))

    def change_front(self, trusted_proxies: tuple[str, ...], allowed_origins: tuple[str, ...]) -> None:
        """Trust other proxies, and allow other web pages, from the next request on."""
        self._settings = replace(self._settings, trusted_proxies=trusted_proxies, allowed_origins=allowed_origins)
        for front in self._fronts:
            front.change(self._settings)

    def stop(self) -> None:
        """Make ``serve`` return."""
        for server in (self._server, *(other for other, _ in self._others)):
            server.should_exit = True

    async def close(self) -> None:
        """End all sessions."""
        await self._background.cancel()
        for protocol in self._protocols:
            await protocol.close()


def build_app(services: Services, sessions: SessionRegistry, settings: FrontSettings) -> Application:
    """Return the application with REST and the robot WebSocket."""
    app = create_app(services, settings)

    async def robot_socket(websocket: WebSocket) -> None:
        await serve_robot_socket(websocket, services, sessions)

    app.router.routes.append(WebSocketRoute("/", robot_socket))
    return app


def log_at(level: str) -> None:
    """Change the least level of the log of a process with a web server, as ``ppaas up --log-level`` names it."""
    logging.getLogger().setLevel(level.upper())
    logging.getLogger("uvicorn.error").setLevel(_server_level(level).upper())


def _server_level(level: str) -> str:
    return "error" if level == "error" else "warning"  # "info" logs each request


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
        log_level=_server_level(log_level),
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
