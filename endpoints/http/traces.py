"""Traces of requests: a span for each request of REST, in the trace of its client or in a new one."""

import re

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ppaas.log_lines import known_fields
from ppaas.tracing.spans import Span, entry

TRACEPARENT = b"traceparent"
"""Header with the trace of the client (W3C Trace Context)."""

PROBES = "/health"
"""Path of the requests that supervisors repeat, which begin no traces."""

SERVER_ERROR = 500

MAX_METHOD = 16
"""Number of characters of the method in the name of a span."""


class TracedRequests:
    """ASGI middleware that records a span for each request below a prefix.

    Parameters
    ----------
    app : ASGI application
        Wrapped application.
    prefix : str
        Prefix of the paths of the REST service.
    """

    def __init__(self, app: ASGIApp, prefix: str) -> None:
        self._app = app
        self._prefix = f"{prefix}/"
        self._probes = re.compile(f"{re.escape(prefix + PROBES)}(/.*)?")
        self._plans = re.compile(f"{re.escape(prefix)}/maps/[^/]+/plans")

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        path = scope["path"]
        if scope["type"] != "http" or not path.startswith(self._prefix) or self._probes.fullmatch(path):
            await self._app(scope, receive, send)
            return
        parents = [value.decode("latin-1") for name, value in scope["headers"] if name == TRACEPARENT]
        method = scope["method"][:MAX_METHOD]
        fields = {f"ppaas.{name}": value for name, value in known_fields().items()}
        request = entry(method, parents[0] if len(parents) == 1 else "", {"http.request.method": method, **fields})

        async def watched(message: Message) -> None:
            if message["type"] == "http.response.start":
                _note_status(request, message["status"])
            await send(message)

        with request:
            try:
                await self._app(scope, receive, watched)
            finally:
                if route := self._route(scope):
                    request.rename(f"{method} {route}")
                    request.set({"http.route": route})

    def _route(self, scope: Scope) -> str:
        """Return the route of a request; empty if there is none. Path requests are answered before they are routed."""
        if self._plans.fullmatch(scope["path"]):
            return f"{self._prefix}maps/{{map_id}}/plans"
        path = str(getattr(scope.get("route"), "path", "")).lstrip("/")
        return f"{self._prefix}{path.removeprefix(self._prefix[1:])}" if path else ""


def _note_status(request: Span, status: int) -> None:
    request.set({"http.response.status_code": status})
    if status >= SERVER_ERROR:
        request.fail(str(status), "")
