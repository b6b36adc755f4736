"""ASGI middleware that records what clients do by REST and by WebSocket.

Recorded are all requests that change something, all connections of robots and operators, and everything that is refused
because of a missing right. Requests that only read or compute are not recorded. Path requests do not even pass through
here: `endpoints.rest.plans.fast_path` answers them.
"""

from collections.abc import Mapping, MutableMapping
from typing import Any
from urllib.parse import parse_qs

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from endpoints.accounts.accounts import ME
from endpoints.accounts.authentication import caller_of
from endpoints.accounts.tokens import TOKEN_PREFIX
from endpoints.audit.event import AuditEvent, AuditLog, Outcome
from endpoints.http.problems import problem_slug
from ppaas.clock import monotonic

# Redaction: the parts of a request that the log may keep, without secrets and without bulk.

PREFIX = "/v1/"
MAX_TEXT = 100
"""Largest length of a text [characters]."""

MAX_ITEMS = 20
"""Largest number of items of a list or an object."""

MAX_DEPTH = 3
"""Largest number of lists and objects within each other."""

SECRET = "(changed)"
"""Text in place of a secret, and of a text with the prefix of tokens."""

TOKEN_SHOWN = 12
"""Number of characters of a token's id that are recorded."""

FIELDS: Mapping[str, tuple[str, ...]] = {
    "create_token": ("name", "robots", "role", "publish", "subscribe", "expires_in"),
    "create_user": ("id", "role", "groups"),
    "change_user": ("role", "password", "limits", "rapyuta_password", "groups", "identity"),
    "put_group": ("members",),
    "share_robot": ("role", "publish", "subscribe"),
    "change_map": ("readers", "description", "traffic"),
    "roll_back_map": ("version", "message"),
    "change_building": ("readers",),
    "put_robot": ("map", "cores"),
    "change_robot": ("map", "cores"),
    "put_people_settings": ("rule", "targets", "history", "retention_hours"),
    "change_people_settings": ("rule", "targets", "history", "retention_hours"),
    "follow_people": ("people",),
    "stop_robot": ("reason",),
    "stop_map": ("reason",),
    "stop_all": ("reason",),
    "release_robot": ("reason",),
    "release_map": ("reason",),
    "release_all": ("reason",),
    "acknowledge_alert": ("alert",),
    "add_task": ("kind", "places", "rounds", "priority", "deadline", "labels"),
    "create_webhook": ("events", "robots", "maps", "description", "state"),
    "change_webhook": ("events", "robots", "maps", "description", "state"),
    "resize_container": ("cores",),
    "change_machine": ("labels", "max_containers", "max_memory", "oversubscription", "draining"),
}
"""Fields of the bodies of operations that are kept."""

SECRETS = frozenset({"password", "old_password", "rapyuta_password", "token"})


def recorded_fields(action: str, body: Any) -> dict[str, Any]:
    """Return the fields of a body that are recorded."""
    if not isinstance(body, dict):
        return {}
    kept = {name: body[name] for name in FIELDS.get(action, ()) if name in body}
    return {name: SECRET if name in SECRETS else _bounded(value) for name, value in kept.items()}


def named_object(scope: Scope) -> str | None:
    """Return the object of a request: noted by its route, else the part of its path up to its last parameter."""
    noted = noted_object(scope)
    if noted is not None:
        return noted
    segments = scope["path"].partition(PREFIX)[2].split("/")
    values = {str(value) for value in scope.get("path_params", {}).values()}
    last = max((at for at, segment in enumerate(segments) if segment in values), default=0)
    return "/".join(_segment(scope, segments, at) for at in range(last + 1)) or None


def _segment(scope: Scope, segments: list[str], at: int) -> str:
    caller, name = caller_of(scope), segments[at]
    kind = segments[at - 1] if at else ""
    if kind == "users" and name == ME and caller is not None:
        return caller.user
    if kind == "tokens":
        return caller.token[:TOKEN_SHOWN] if name == "current" and caller is not None else plain(name)[:TOKEN_SHOWN]
    return plain(name)


def plain(text: str) -> str:
    """Return a text without control characters, bounded, and replaced if it looks like a token."""
    if TOKEN_PREFIX in text:
        return SECRET
    shown = "".join(character if character.isprintable() else " " for character in text[:MAX_TEXT])
    return shown.encode("utf-8", "replace").decode()


def _bounded(value: Any, depth: int = 0) -> Any:
    match value:
        case str():
            return plain(value)
        case list() | dict() if depth >= MAX_DEPTH:
            return "…"
        case list():
            return [_bounded(one, depth + 1) for one in value[:MAX_ITEMS]]
        case dict():
            items = list(value.items())[:MAX_ITEMS]
            return {plain(str(name)): _bounded(one, depth + 1) for name, one in items if name not in SECRETS}
        case bool() | int() | float() | None:
            return value
        case _:
            return plain(str(value))


# Notes of routes in the ASGI scope of a request: what neither path nor body contains.

_OBJECT, _DETAILS, _REFUSAL = "ppaas.audit.object", "ppaas.audit.details", "ppaas.audit.refusal"


def note_object(scope: MutableMapping[str, Any], name: str) -> None:
    """Note the object of the action, as ``maps/office``; it replaces the object that the path names."""
    scope[_OBJECT] = name


def note_details(scope: MutableMapping[str, Any], **details: Any) -> None:
    """Note what was changed; never a secret."""
    scope.setdefault(_DETAILS, {}).update(details)


def noted_object(scope: MutableMapping[str, Any]) -> str | None:
    """Return the noted object, if there is one."""
    return scope.get(_OBJECT)


def noted_details(scope: MutableMapping[str, Any]) -> dict[str, Any]:
    """Return the noted details."""
    return dict(scope.get(_DETAILS, {}))


def note_refusal(scope: MutableMapping[str, Any], status: int) -> None:
    """Note the status of a WebSocket that is accepted only to report why it is refused."""
    scope[_REFUSAL] = status


def noted_refusal(scope: MutableMapping[str, Any]) -> int | None:
    """Return the status of a refused WebSocket; None if it is not refused."""
    return scope.get(_REFUSAL)


_KEY = "ppaas.body"


def note_body(scope: MutableMapping[str, Any], body: Any) -> None:
    """Note the parsed body of a request."""
    scope[_KEY] = body


def parsed_body(scope: MutableMapping[str, Any]) -> Any:
    """Return the parsed body of a request; None if it was not read as JSON."""
    return scope.get(_KEY)


# The middleware, and the classes of requests that it does not record.

READING = frozenset({"GET", "HEAD", "OPTIONS"})
COMPUTING = frozenset(
    {
        "make_plan",
        "compute_costs",
        "plan_fleet",
        "check_zones",
        "check_building",
        "plan_in_building",
        "compute_building_costs",
    }
)
"""Operations by POST that change nothing."""

OPENING = frozenset({"issue_ticket"})
"""Operations that let a client connect once and soon, which is recorded as ``connect``."""

POLLING = frozenset({"log_in_by_device"})
"""Operations that are repeated while their answer is 202, which is not recorded."""

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
        changes = scope["method"] not in READING and action not in COMPUTING | OPENING
        changes = changes and not (status == 202 and action in POLLING)
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
