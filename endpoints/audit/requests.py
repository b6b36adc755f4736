"""ASGI middleware that records what clients do by REST and by WebSocket.

Recorded are all requests that change something, all connections of robots and operators, and everything that is refused
because of a missing right. Requests that only read or compute are not recorded. Path requests do not even pass through
here: `endpoints.rest.plans.fast_path` answers them.
"""

from typing import Any
from urllib.parse import parse_qs

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from endpoints.accounts.caller import caller_of
from endpoints.audit.event import AuditEvent, AuditLog, Outcome
from endpoints.audit.notes import noted_details, noted_object, noted_refusal
from endpoints.audit.redaction import TOKEN_SHOWN, named_object, plain, recorded_fields
from endpoints.http.parsed_body import parsed_body
from endpoints.http.problems import problem_slug
from ppaas.clock import monotonic

READING = frozenset({"GET", "HEAD", "OPTIONS"})
COMPUTING = frozenset({"make_plan", "compute_costs", "plan_fleet", "check_zones"})
"""Operations by POST that change nothing."""

NO_RIGHT = frozenset({401, 403})
"""Statuses that are recorded for every operation."""


class AuditedRequests:
    """Records requests and connections.

    Parameters
    ----------
    app : ASGI application
        Serves them.
    log : AuditLog
        Log of the events.
    """

    def __init__(self, app: ASGIApp, log: AuditLog) -> None:
        self._app = app
        self._log = log

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request or connection."""
        if scope["type"] == "http":
            await self._request(scope, receive, send)
        elif scope["type"] == "websocket":
            await _AuditedSocket(self._log, scope, receive, send).serve(self._app)
        else:
            await self._app(scope, receive, send)

    async def _request(self, scope: Scope, receive: Receive, send: Send) -> None:
        status = 0

        async def watch(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                self._record(scope, status)  # before the client has the answer
            await send(message)

        try:
            await self._app(scope, receive, watch)
        finally:
            if not status:
                self._record(scope, status)

    def _record(self, scope: Scope, status: int) -> None:
        action = getattr(scope.get("route"), "name", "")
        changes = scope["method"] not in READING and action not in COMPUTING
        if action and (changes or status in NO_RIGHT):
            fields = recorded_fields(action, parsed_body(scope)) | noted_details(scope)
            self._log.record(_event(scope, action, status, named_object(scope), fields))


class _AuditedSocket:
    """One WebSocket, from its handshake to its end."""

    def __init__(self, log: AuditLog, scope: Scope, receive: Receive, send: Send) -> None:
        self._log = log
        self._scope = scope
        self._receive = receive
        self._send = send
        self._opened: float | None = None
        self._end: dict[str, Any] = {}

    async def serve(self, app: ASGIApp) -> None:
        """Serve the connection."""
        try:
            await app(self._scope, self._take, self._pass)
        finally:
            if self._opened is not None:
                self._record("disconnect", 0, {"seconds": round(monotonic() - self._opened, 1)} | self._end)

    async def _take(self) -> Message:
        message = await self._receive()
        if message["type"] == "websocket.disconnect":
            self._ended(message)
        return message

    async def _pass(self, message: Message) -> None:
        kind = message["type"]
        if kind == "websocket.accept":
            self._opened = monotonic()
            self._record("connect", noted_refusal(self._scope) or 101, {})
        elif kind == "websocket.http.response.start" and "endpoint" in self._scope:
            self._record("connect", message["status"], {})
        elif kind == "websocket.close":
            self._ended(message)
        await self._send(message)

    def _ended(self, message: Message) -> None:
        reason = str(message.get("reason") or "")
        self._end = self._end or {"code": message.get("code", 1000)} | ({"reason": plain(reason)} if reason else {})

    def _record(self, action: str, status: int, details: dict[str, Any]) -> None:
        query = parse_qs(self._scope.get("query_string", b"").decode("latin-1"))
        robot, role = (plain(query.get(name, [""])[0]) for name in ("robot", "role"))
        target = noted_object(self._scope) or (f"robots/{robot}" if robot else None)
        details = {"role": role or "robot"} | details | noted_details(self._scope)
        self._log.record(_event(self._scope, action, status, target, details))


def _event(scope: Scope, action: str, status: int, target: str | None, details: dict[str, Any]) -> AuditEvent:
    caller, client = caller_of(scope), scope.get("client")
    socket_end = action == "disconnect"
    return AuditEvent(
        action=action,
        outcome="ok" if socket_end else _outcome(status),
        user=caller.user if caller else None,
        token=caller.token[:TOKEN_SHOWN] if caller else None,
        address=client[0] if client else "",
        object=target,
        status=status or None,
        reason=None if socket_end else problem_slug(scope) if status else "no-answer",
        details=details,
    )


def _outcome(status: int) -> Outcome:
    if 100 <= status < 400:
        return "ok"
    return "refused" if 400 <= status < 500 else "failed"
