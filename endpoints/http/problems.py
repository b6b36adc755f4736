"""Responses of errors: ``application/problem+json`` of RFC 9457, from one table; the log of what clients did wrong."""

import http
import json
import logging
import math
from collections.abc import Collection, Mapping, MutableMapping, Sequence
from functools import partial
from typing import Any

from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.routing import compile_path
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ppaas import errors
from ppaas.bounded import BoundedDict
from ppaas.clock import Clock, monotonic

logger = logging.getLogger(__name__)


PER_SECOND = 3
"""Largest number of warnings about one address in a second."""

MAX_ADDRESSES = 1024
"""Number of addresses that are remembered."""

MAX_TEXT = 500
"""Largest length of a warning, which may quote the client [characters]."""


class RefusalLog:
    """Records about clients, limited per address, so that nobody fills the log.

    Parameters
    ----------
    logger : Logger
        Logger of the module that refuses.
    clock : callable
        Returns monotonic time [s].
    level : int
        Level of the records.
    """

    def __init__(self, logger: logging.Logger, clock: Clock = monotonic, level: int = logging.WARNING) -> None:
        self._log = partial(logger.log, level)
        self._clock = clock
        self._seen: BoundedDict[str, tuple[float, int]] = BoundedDict(MAX_ADDRESSES)

    def add(self, address: str, text: str) -> None:
        """Log a warning about a client at this address, unless there were `PER_SECOND` within the last second."""
        now = self._clock()
        began, count = self._seen.get(address, (now, 0))
        if now - began >= 1.0:
            if count > PER_SECOND:
                self._log("%s: %d more warnings like these were not logged", address, count - PER_SECOND)
            began, count = now, 0
        self._seen[address] = (began, count + 1)
        if count < PER_SECOND:
            self._log("%s: %s", address, text[:MAX_TEXT].translate(_CONTROL))


_CONTROL = dict.fromkeys((*range(32), 127), " ")
"""Control characters, a new line among them: text of a client must not forge a line of the log."""


USER = "user"
"""Name of the authenticated user in the state of a request."""

_hidden = RefusalLog(logger)
_refused = RefusalLog(logger, level=logging.INFO)

Operations = Sequence[tuple[str, Collection[str]]]
"""Paths of routes, with the methods of each."""

MEDIA_TYPE = "application/problem+json"
TYPE = "urn:ppaas:problem:"
RETRY_AFTER = 1
"""Retry-After of responses with status 503 [s]."""

QUEUE_RETRY = 2
"""Retry-After of requests that wait in the queue [s]."""

MAX_PROBLEMS = 20
"""Largest number of errors of one request that are reported."""

STATUS: dict[type[errors.PPaaSError], tuple[int, str]] = {
    errors.PPaaSError: (500, "Error"),
    errors.InvalidInput: (400, "Invalid input"),
    errors.MalformedMessage: (400, "Malformed message"),
    errors.MessageTooLarge: (413, "Too large"),
    errors.UnknownType: (400, "Unknown type"),
    errors.InvalidMap: (422, "Invalid map"),
    errors.InvalidUrdf: (422, "Invalid URDF"),
    errors.InvalidBuilding: (422, "Invalid building"),
    errors.InvalidZones: (422, "Invalid zones"),
    errors.InvalidParameter: (422, "Invalid parameter"),
    errors.InvalidRobot: (422, "Invalid robot"),
    errors.NotFound: (404, "Not found"),
    errors.Conflict: (409, "Conflict"),
    errors.NotAuthenticated: (401, "Not authenticated"),
    errors.NotPermitted: (403, "Not permitted"),
    errors.QuotaExceeded: (429, "Quota exceeded"),
    errors.TooManyAttempts: (429, "Too many attempts"),
    errors.Unavailable: (503, "Unavailable"),
    errors.Starting: (503, "Starting"),
    errors.TransformError: (422, "No transform"),
    errors.PlanningError: (422, "Planning failed"),
}
"""HTTP status and title of each error; other errors use their nearest base class."""

_SLUG = "ppaas.problem"
"""Key in the ASGI scope."""

_HEADERS: dict[int, dict[str, str]] = {
    401: {"WWW-Authenticate": 'Bearer realm="ppaas"'},
    503: {"Retry-After": str(RETRY_AFTER)},
}


class ProblemResponse(Response):
    """Response of a problem, which notes the slug of the problem in the ASGI scope, and logs it."""

    slug = ""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the response."""
        scope[_SLUG] = self.slug
        if scope["type"] == "http":
            client = (scope.get("client") or ("unknown",))[0]
            _refused.add(client, f"{scope['method']} {scope['path']}: {self.status_code} {self.slug}")
        await super().__call__(scope, receive, send)


def problem_slug(scope: MutableMapping[str, Any]) -> str | None:
    """Return the slug of the problem with which a request was answered; None if it was answered otherwise."""
    return scope.get(_SLUG)


def problem(
    status: int, slug: str, title: str, detail: str, headers: Mapping[str, str] | None = None, **members: Any
) -> Response:
    """Return a problem response; ``members`` are additional keys of its body."""
    body = {"type": TYPE + slug, "title": title, "status": status, "detail": detail, **members}
    all_headers = {**_HEADERS.get(status, {}), **(headers or {})}
    # Escaped to ASCII: text of the client may be quoted, and need not be encodable as UTF-8.
    response = ProblemResponse(json.dumps(body, allow_nan=False), status, all_headers, MEDIA_TYPE)
    response.slug = slug
    return response


def status_problem(status: int, detail: str, headers: Mapping[str, str] | None = None) -> Response:
    """Return the problem response of an HTTP status, with the name of the status as title and slug."""
    title = http.HTTPStatus(status).phrase
    return problem(status, title.lower().replace(" ", "-").replace("'", ""), title, detail, headers)


def problem_response(error: errors.PPaaSError, *, to_admin: bool = False) -> Response:
    """Return the response of an error.

    Planning errors have their Nav2 ``code`` (201–208), and errors of zones and robot files their ``faults``.
    A request that waits in the queue, as it allowed, is not a problem: it is accepted (202) with its position. What
    only operators may read is logged, and sent to administrators.
    """
    if isinstance(error, errors.Queued):
        body = {"position": error.position, "detail": str(error)}
        return Response(json.dumps(body), 202, {"Retry-After": str(QUEUE_RETRY)}, "application/json")
    status, title = next(STATUS[kind] for kind in type(error).__mro__ if kind in STATUS)
    # The rest of a too large body is not read; on an open connection it would be taken for the next request.
    headers = {"Connection": "close"} if status == http.HTTPStatus.REQUEST_ENTITY_TOO_LARGE else _retry(error)
    if error.public != str(error):
        _hidden.add(error.slug, str(error))
    return problem(status, error.slug, title, str(error) if to_admin else error.public, headers, **_members(error))


def _members(error: errors.PPaaSError) -> dict[str, Any]:
    if isinstance(error, errors.PlanningError) and error.code:
        return {"code": error.code}
    if isinstance(error, errors.InvalidZones | errors.InvalidRobot) and error.faults:
        return {"faults": [fault._asdict() for fault in error.faults]}
    return {}


def _retry(error: errors.PPaaSError) -> dict[str, str]:
    """Return the Retry-After header (RFC 9110: whole seconds) if the error has a time."""
    after = error.retry_after if isinstance(error, errors.QuotaExceeded | errors.Starting) else None
    return {} if after is None else {"Retry-After": str(math.ceil(after))}


def add_problem_handlers(app: FastAPI, operations: Operations) -> None:
    """Make an application respond to every error with a problem; ``operations`` belong to its service."""
    app.add_exception_handler(errors.PPaaSError, _domain_error)
    app.add_exception_handler(RequestValidationError, _validation_error)
    app.add_exception_handler(HTTPException, partial(_http_error, operations))
    app.add_middleware(UnexpectedErrors)


class UnexpectedErrors:
    """ASGI middleware that answers unexpected exceptions with status 500 and logs them once.

    A client that disconnects while its body is read is none: that is no fault of the cloud, and not logged.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        started = False

        async def watch(message: Message) -> None:
            nonlocal started
            started = True
            await send(message)

        try:
            await self._app(scope, receive, watch)
        except ClientDisconnect:
            # Nobody reads the answer, but those who record requests and their outcome need one.
            if not started:
                await status_problem(400, "the connection ended before the body was complete")(scope, receive, send)
        except Exception:
            # A started response can only be aborted; the server does this and logs it.
            if started or scope["type"] != "http":
                raise
            await unexpected(scope)(scope, receive, send)


def unexpected(scope: Scope) -> Response:
    """Return the response of an unexpected failure, and log the exception being handled."""
    logger.exception("%s %s failed", scope["method"], scope["path"])
    return problem(500, "internal-error", "Internal error", "the cloud failed: see its log")


async def _domain_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, errors.PPaaSError)
    user = getattr(request.state, USER, None)
    return problem_response(error, to_admin=user is not None and user.role == "admin")


async def _http_error(operations: Operations, request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    # FastAPI reports any error while reading a body, such as a too large body, as an error of parsing.
    if isinstance(error.__cause__, errors.PPaaSError):
        return problem_response(error.__cause__)
    headers = dict(error.headers or {})
    if error.status_code == http.HTTPStatus.METHOD_NOT_ALLOWED:
        headers["Allow"] = ", ".join(sorted(_allowed(operations, request.url.path))) or headers.get("Allow", "")
    return status_problem(error.status_code, str(error.detail), headers)


def _allowed(operations: Operations, asked: str) -> set[str]:
    """Return all methods of a path; Starlette reports only the methods of its first route."""
    methods = {method for path, methods in operations if compile_path(path)[0].match(asked) for method in methods}
    return methods | {"HEAD"} if "GET" in methods else methods


async def _validation_error(_request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    faults = _faults(error.errors())
    detail = "; ".join(f"{'.'.join(fault['where'])}: {fault['what']}" for fault in faults)
    return problem(422, "invalid-request", "Invalid request", detail, errors=faults)


def _faults(found: Sequence[Any]) -> list[dict[str, Any]]:
    """Return location and message of each error without the input, which may be large or a password."""
    return [
        {"where": [str(step)[:64] for step in fault["loc"]], "what": str(fault["msg"])}
        for fault in found[:MAX_PROBLEMS]
    ]
