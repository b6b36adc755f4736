"""Front of the web application: what is decided about a request before any route sees it.

It gets an id, its path prefix is removed, the address of the client is taken from the headers of trusted proxies,
compressed bodies and WebSockets at wrong paths or of foreign pages are refused, and answers of the REST service are
kept out of caches.
"""

import re
import secrets
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, cast

from starlette.datastructures import Headers, MutableHeaders, QueryParams
from starlette.middleware.cors import CORSMiddleware
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket
from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware

from endpoints.http.front_settings import FrontSettings, is_prefix, may_open
from endpoints.http.problems import problem_response, status_problem
from endpoints.http.traces import TracedRequests
from endpoints.http.websocket_protocol import CONNECTION
from ppaas.errors import NotPermitted, PPaaSError, rebuild
from ppaas.log_lines import log_fields
from ppaas.tracing.spans import are_recorded

# Changes that proxies make to requests: a prefix of the path, and another address of the client.

PREFIX = "ppaas.prefix"
"""Key of the path prefix in the ASGI scope."""


def prefix_of(scope: Mapping[str, Any]) -> str:
    """Return the path below which a proxy serves the cloud, if it is known; otherwise empty."""
    return str(scope.get(PREFIX, ""))


class PathPrefix:
    """ASGI middleware that removes a path prefix; requests whose proxy has removed it pass, too.

    Parameters
    ----------
    app : ASGI application
        Wrapped application.
    prefix : str
        Prefix.
    """

    def __init__(self, app: ASGIApp, prefix: str) -> None:
        self._app = app
        self._prefix = prefix

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request or connection."""
        if scope["type"] in ("http", "websocket"):
            scope = without_prefix(scope, self._prefix)
        await self._app(scope, receive, send)


def without_prefix(scope: Scope, prefix: str) -> Scope:
    """Return the scope of a request below a prefix."""
    path: str = scope["path"]
    if path == prefix:
        path = "/"
    elif path.startswith(f"{prefix}/"):
        path = path[len(prefix) :]
    return {**scope, "path": path, PREFIX: prefix}


class TrustedProxies:
    """ASGI middleware that believes the headers ``X-Forwarded-For``, ``-Proto``, ``-Host`` and ``-Prefix`` of proxies.

    Parameters
    ----------
    app : ASGI application
        Wrapped application.
    root_path : str
        Path prefix of requests without ``X-Forwarded-Prefix``.
    proxies : iterable of str
        Addresses and networks of the proxies; the headers of others are ignored.
    """

    def __init__(self, app: ASGIApp, root_path: str, proxies: Iterable[str]) -> None:
        self._app = app
        self._root_path = root_path
        self._clients = ProxyHeadersMiddleware(cast(Any, self._serve), list(proxies))

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request or connection."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        prefix = self._root_path
        client = scope.get("client")
        if client and client[0] in self._clients.trusted_hosts:
            headers = Headers(scope=scope)
            given = headers.get("x-forwarded-prefix", "").rstrip("/")
            prefix = given if is_prefix(given) else prefix
            scope = _with_host(scope, headers.get("x-forwarded-host"))
        if prefix:
            scope = without_prefix(scope, prefix)
        await self._clients(cast(Any, scope), cast(Any, receive), cast(Any, send))

    async def _serve(self, scope: Scope, receive: Receive, send: Send) -> None:
        connection = scope.get("state", {}).get(CONNECTION)
        if connection is not None and scope.get("client"):
            connection.client = tuple(scope["client"])  # by which it logs what a client did wrong
        await self._app(scope, receive, send)


def _with_host(scope: Scope, host: str | None) -> Scope:
    """Return a scope with another Host; of a list, the first is the one that the client sent."""
    if not host:
        return scope
    first = host.partition(",")[0].strip().encode("latin-1")
    others = [(name, value) for name, value in scope["headers"] if name != b"host"]
    return {**scope, "headers": [(b"host", first), *others]}


# Ids of requests: each answer names one, by which its lines are found in the log.

REQUEST_ID = "X-Request-ID"
"""Header of the id, in requests and answers."""

_REQUEST_ID_NAME = REQUEST_ID.lower().encode()

_SAFE_ID = re.compile(rb"[A-Za-z0-9._-]{1,64}")
"""Ids that are taken from clients: what every log, shell and header can hold."""

_ROBOT_PATH = re.compile("/v1/robots/([^/]{1,129})(?:/goals/([^/]{1,64}))?(?:/|$)")
"""Paths of robots and of their goals."""


class RequestIds:
    """ASGI middleware that gives each request the id that its client sent, or a new one.

    The lines that the request writes to the log as JSON hold it, with the robot and the goal of its path.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        given = next((value for name, value in scope["headers"] if name == _REQUEST_ID_NAME), b"")
        request = given.decode() if _SAFE_ID.fullmatch(given) else secrets.token_hex(8)

        async def named(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message)[REQUEST_ID] = request
            await send(message)

        with log_fields(request=request, **_fields_of(scope["path"])):
            await self._app(scope, receive, named)


def _fields_of(path: str) -> dict[str, str]:
    found = _ROBOT_PATH.match(path)
    if found is None:
        return {}
    return {name: value for name, value in zip(("robot", "goal"), found.groups(), strict=True) if value is not None}


METHODS = ("GET", "POST", "PUT", "PATCH", "DELETE")
HEADERS_TAKEN = ("Authorization", "Content-Type", "If-Match", REQUEST_ID)
HEADERS_SHOWN = ("Location", "Retry-After", "Content-Disposition", REQUEST_ID)

PREFLIGHT_SECONDS = 600
"""Time for which browsers keep the answer to the question whether a page may send a request [s]."""


class ApplicationFront:
    """Application behind its front.

    Parameters
    ----------
    app : ASGI application
        Application.
    settings : FrontSettings
        Settings.
    private : str
        Prefix of the paths whose answers no cache may keep.
    origins : tuple of str, optional
        Origins that are allowed, whatever the settings say.
    """

    def __init__(
        self, app: ASGIApp, settings: FrontSettings, private: str, origins: tuple[str, ...] | None = None
    ) -> None:
        self._app = app
        self._private = private
        self._origins = origins
        self.change(settings)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request or connection."""
        await self._first(scope, receive, send)

    def change(self, settings: FrontSettings) -> None:
        """Apply other settings to the requests and connections that come from now on."""
        origins = settings.allowed_origins if self._origins is None else self._origins
        self._first = _front(self._app, replace(settings, allowed_origins=origins), self._private)


def _front(app: ASGIApp, settings: FrontSettings, private: str) -> ASGIApp:
    app = Gate(app, settings.allowed_origins, private)
    if settings.allowed_origins:
        app = _allow_origins(app, settings.allowed_origins)
    if are_recorded():
        app = TracedRequests(app, private)
    app = RequestIds(app)
    if settings.trusted_proxies:
        app = TrustedProxies(app, settings.root_path, settings.trusted_proxies)
    elif settings.root_path:
        app = PathPrefix(app, settings.root_path)
    return app


def _allow_origins(app: ASGIApp, origins: Iterable[str]) -> ASGIApp:
    """Return an application that pages of other hosts may use (CORS, Fetch standard)."""
    return CORSMiddleware(
        app,
        allow_origins=list(origins),
        allow_methods=METHODS,
        allow_headers=HEADERS_TAKEN,
        expose_headers=HEADERS_SHOWN,
        max_age=PREFLIGHT_SECONDS,
    )


class Gate:
    """ASGI middleware that refuses compressed bodies and misdirected WebSockets, and keeps answers out of caches.

    Parameters
    ----------
    app : ASGI application
        Wrapped application.
    origins : iterable of str
        Origins of pages on other hosts that may open WebSockets.
    private : str
        Prefix of the paths whose answers no cache may keep (RFC 6750, 5.3).
    """

    def __init__(self, app: ASGIApp, origins: Iterable[str], private: str) -> None:
        self._app = app
        self._origins = frozenset(origins)
        self._private = f"{private}/"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request or connection."""
        if scope["type"] == "websocket":
            refusal = self._fault_of(scope)
            if refusal is not None:
                await _deny(WebSocket(scope, receive, send), refusal)
                return
        elif scope["type"] == "http":
            if scope["path"].startswith(self._private):
                send = _uncached(send)
            coding = next((value for name, value in scope["headers"] if name == b"content-encoding"), b"identity")
            if coding.strip().lower() not in (b"", b"identity"):
                await _compressed(coding)(scope, receive, send)
                return
        await self._app(scope, receive, send)

    def _fault_of(self, scope: Scope) -> PPaaSError | None:
        path = scope["path"]
        if path != "/":
            own = f"{prefix_of(scope)}/?robot=ID"
            return rebuild("not-found", f"the WebSocket of robots is at {own}, not at {path[:128]!a}")
        headers = Headers(scope=scope)
        if headers.get("authorization", "").lower().startswith("bearer "):
            return None  # no page can send this header
        if QueryParams(scope["query_string"]).get("ticket"):
            return None  # a page gets one by REST only, which its origin decides
        origin = headers.get("origin", "")
        if not may_open(origin, headers.get("host", ""), self._origins):
            return NotPermitted(
                f"web pages of {origin[:128]!a} may not use this cloud: start it with --allow-origin, or have the "
                "proxy in between keep the Host header"
            )
        return None


async def _deny(socket: WebSocket, error: PPaaSError) -> None:
    connection = socket.scope.get("state", {}).get(CONNECTION)
    if connection is not None:
        connection.warn(f"refused: {error.slug}: {error}")
    await socket.send_denial_response(problem_response(error))


def _compressed(coding: bytes) -> Response:
    """Return the refusal of a compressed body (RFC 9110, 15.5.16)."""
    return status_problem(
        415,
        f"Content-Encoding {coding.decode('latin-1')[:64]!a} is not supported: send the body without compression",
        {"Accept-Encoding": "identity", "Connection": "close"},
    )


def _uncached(send: Send) -> Send:
    """Return a ``send`` whose responses no cache keeps, unless they say otherwise."""

    async def uncached(message: Message) -> None:
        if message["type"] == "http.response.start":
            MutableHeaders(scope=message).setdefault("Cache-Control", "no-store")
        await send(message)

    return uncached


# HEAD for every resource that has GET (RFC 9110, section 9.1).


class HeadRequests:
    """ASGI middleware that answers HEAD like GET, without the body.

    The server drops the body of the answer. A body that is sent in parts is not read to its end: after the first part,
    the application receives the message that the client has disconnected.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] == "http" and scope["method"] == "HEAD":
            head = _Head(receive, send)
            await self._app({**scope, "method": "GET"}, head.receive, head.send)
        else:
            await self._app(scope, receive, send)


class _Head:
    """Answer to one HEAD request."""

    def __init__(self, receive: Receive, send: Send) -> None:
        self._receive = receive
        self._send = send
        self._complete = False

    async def receive(self) -> Message:
        return {"type": "http.disconnect"} if self._complete else await self._receive()

    async def send(self, message: Message) -> None:
        if self._complete:
            return
        if message["type"] == "http.response.body":
            self._complete = True
            message = {"type": "http.response.body", "body": b"", "more_body": False}
        await self._send(message)
