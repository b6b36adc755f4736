"""Changes that proxies make to requests: a prefix of the path, and another address of the client."""

from collections.abc import Iterable, Mapping
from typing import Any, cast

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send
from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware

from endpoints.http.front_settings import is_prefix
from endpoints.http.websocket_protocol import CONNECTION

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
