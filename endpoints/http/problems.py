"""Errors as HTTP answers: ``application/problem+json`` of RFC 9457, one table for all."""

import http
import json
import logging
import math
from collections.abc import Mapping, Sequence
from typing import Any

from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import compile_path
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ppaas import errors

logger = logging.getLogger(__name__)

MEDIA_TYPE = "application/problem+json"
TYPE = "urn:ppaas:problem:"
RETRY_AFTER = 1
"""Seconds after which what is unavailable may be tried again."""

QUEUE_RETRY = 2
"""Seconds after which whoever waits in the queue asks again."""

MAX_PROBLEMS = 20
"""Faults of one body that are told."""

STATUS: dict[type[errors.PPaaSError], tuple[int, str]] = {
    errors.PPaaSError: (500, "Error"),
    errors.InvalidInput: (400, "Invalid input"),
    errors.MalformedMessage: (400, "Malformed message"),
    errors.MessageTooLarge: (413, "Too large"),
    errors.UnknownType: (400, "Unknown type"),
    errors.InvalidMap: (422, "Invalid map"),
    errors.InvalidUrdf: (422, "Invalid URDF"),
    errors.InvalidParameter: (422, "Invalid parameter"),
    errors.NotFound: (404, "Not found"),
    errors.Conflict: (409, "Conflict"),
    errors.NotAuthenticated: (401, "Not authenticated"),
    errors.NotPermitted: (403, "Not permitted"),
    errors.QuotaExceeded: (429, "Quota exceeded"),
    errors.Unavailable: (503, "Unavailable"),
    errors.TransformError: (422, "No transform"),
    errors.PlanningError: (422, "Planning failed"),
}
"""HTTP status and title of each error; one that is not here has those of its nearest base."""

_HEADERS: dict[int, dict[str, str]] = {
    401: {"WWW-Authenticate": 'Bearer realm="ppaas"'},
    503: {"Retry-After": str(RETRY_AFTER)},
}


def problem(
    status: int, slug: str, title: str, detail: str, headers: Mapping[str, str] | None = None, **members: Any
) -> Response:
    """Return the answer that tells of a problem; ``members`` are more of its keys."""
    body = {"type": TYPE + slug, "title": title, "status": status, "detail": detail, **members}
    all_headers = {**_HEADERS.get(status, {}), **(headers or {})}
    # Escaped to ASCII: what a client sent may be told back, and need not be encodable.
    return Response(json.dumps(body, allow_nan=False), status, all_headers, MEDIA_TYPE)


def problem_response(error: errors.PPaaSError) -> Response:
    """Return the answer for an error of the domain; a planning error tells its Nav2 ``code`` (201–208).

    What waits in the queue, as was asked for, is no problem: it is accepted, and told its position.
    """
    if isinstance(error, errors.Queued):
        body = {"position": error.position, "detail": str(error)}
        return Response(json.dumps(body), 202, {"Retry-After": str(QUEUE_RETRY)}, "application/json")
    status, title = next(STATUS[kind] for kind in type(error).__mro__ if kind in STATUS)
    code = error.code if isinstance(error, errors.PlanningError) else 0
    members = {"code": code} if code else {}
    # The rest of a body that is too large is not read: without closing, it would be taken for the next request.
    headers = {"Connection": "close"} if status == http.HTTPStatus.REQUEST_ENTITY_TOO_LARGE else _retry(error)
    return problem(status, error.slug, title, str(error), headers, **members)


def _retry(error: errors.PPaaSError) -> dict[str, str]:
    """Return when to ask again (RFC 9110: whole seconds), where an error knows it."""
    after = error.retry_after if isinstance(error, errors.QuotaExceeded) else None
    return {} if after is None else {"Retry-After": str(math.ceil(after))}


def add_problem_handlers(app: FastAPI) -> None:
    """Have an application answer every error with a problem."""
    app.add_exception_handler(errors.PPaaSError, _domain_error)
    app.add_exception_handler(RequestValidationError, _validation_error)
    app.add_exception_handler(HTTPException, _http_error)
    app.add_middleware(UnexpectedErrors)


class UnexpectedErrors:
    """Answers what nobody foresaw with a plain 500; the log has the rest, once."""

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
        except Exception:
            # Once begun, an answer can only be cut off, which the server does, and logs.
            if started or scope["type"] != "http":
                raise
            await unexpected(scope)(scope, receive, send)


def unexpected(scope: Scope) -> Response:
    """Return the answer to a request that failed as nobody foresaw, and log the exception being handled."""
    logger.exception("%s %s failed", scope["method"], scope["path"])
    return problem(500, "internal-error", "Internal error", "the cloud failed; its log says why")


async def _domain_error(_request: Request, error: Exception) -> Response:
    assert isinstance(error, errors.PPaaSError)
    return problem_response(error)


async def _http_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    # FastAPI says "error parsing the body" of whatever came up meanwhile, such as a body that is too large.
    if isinstance(error.__cause__, errors.PPaaSError):
        return problem_response(error.__cause__)
    title = http.HTTPStatus(error.status_code).phrase
    slug = title.lower().replace(" ", "-").replace("'", "")
    headers = dict(error.headers or {})
    if error.status_code == http.HTTPStatus.METHOD_NOT_ALLOWED:
        headers["Allow"] = ", ".join(sorted(_allowed(request))) or headers.get("Allow", "")
    return problem(error.status_code, slug, title, str(error.detail), headers)


def _allowed(request: Request) -> set[str]:
    """Return all methods of a path: each is a route of its own, and Starlette tells those of the first alone."""
    paths = request.app.openapi()["paths"].items()
    found = [methods for path, methods in paths if compile_path(path)[0].match(request.url.path)]
    return {method.upper() for methods in found for method in methods}


async def _validation_error(_request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    faults = _faults(error.errors())
    detail = "; ".join(f"{'.'.join(fault['where'])}: {fault['what']}" for fault in faults)
    return problem(422, "invalid-request", "Invalid request", detail, errors=faults)


def _faults(found: Sequence[Any]) -> list[dict[str, Any]]:
    """Return where each fault is and what it is, and nothing of what was sent: it may be large, or a password."""
    return [
        {"where": [str(step)[:64] for step in fault["loc"]], "what": str(fault["msg"])}
        for fault in found[:MAX_PROBLEMS]
    ]
