"""Requests for paths, served before FastAPI looks for their route."""

import re
from collections import deque
from typing import Annotated

import msgspec
from msgspec import Meta
from starlette.exceptions import HTTPException
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from endpoints.accounts.authentication import bearer_of
from endpoints.http.problems import problem_response, unexpected
from endpoints.rest.plans.planning import allowed_timeout, plan_and_keep
from endpoints.rest.schemas import MAX_COORDINATE, triple
from endpoints.services.services import Services
from engine.service.path_requests import PathRequest
from ppaas.errors import PPaaSError
from storage.names import is_name

_Pose = Annotated[list[Annotated[float, Meta(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]], Meta(min_length=2, max_length=3)]


class _Asked(msgspec.Struct, forbid_unknown_fields=True):
    """What ``PlanFile`` says of a path; no more than that is taken, but it may be less."""

    start: _Pose
    goal: _Pose
    planner: str = "dijkstra"
    tolerance: Annotated[float, Meta(ge=0.0)] = 0.0
    timeout: Annotated[float, Meta(gt=0.0)] | None = None
    reuse: bool = True


_decoder = msgspec.json.Decoder(_Asked)
_QUOTED = tuple(f'"{name}"'.encode() for name in _Asked.__struct_fields__)


class DirectPlans:
    """ASGI middleware that serves a request for a path before all of FastAPI, if it is right.

    FastAPI takes a millisecond for it. Whatever is wrong with a request, or only unusual, what is behind is left to
    serve, from its first message on.

    Parameters
    ----------
    app : ASGI application
        Who serves all else.
    prefix : str
        Of the paths of the service.
    services : Services
        What is served with.
    """

    def __init__(self, app: ASGIApp, prefix: str, services: Services) -> None:
        self._app = app
        self._path = re.compile(f"{re.escape(prefix)}/maps/([^/]+)/plans")
        self._services = services

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        token = found = None
        if scope["type"] == "http" and scope["method"] == "POST":
            found = self._path.fullmatch(scope["path"])
            token = _token(scope["headers"])
        if found is None or token is None or not is_name(found[1]):
            await self._app(scope, receive, send)
            return
        read = list[Message]()
        try:
            asked = await _asked(receive, read)
        except HTTPException:
            asked = None
        except PPaaSError as error:
            await problem_response(error)(scope, receive, send)
            return
        if asked is None:
            await self._app(scope, _again(read, receive), send)
            return
        response = await self._answer(scope, found[1], token, asked)
        await response(scope, receive, send)

    async def _answer(self, scope: Scope, map_id: str, token: str, asked: _Asked) -> Response:
        services = self._services
        try:
            user = await services.accounts.authenticate(token)
            request = PathRequest(
                triple(asked.start), triple(asked.goal), asked.planner, asked.tolerance,
                allowed_timeout(asked.timeout, services.settings), asked.reuse,
            )  # fmt: skip
            return await plan_and_keep(services, user, map_id, request)
        except PPaaSError as error:
            return problem_response(error)
        except Exception:  # noqa: BLE001  # logged, and nobody stands before this to answer
            return unexpected(scope)


def _token(headers: list[tuple[bytes, bytes]]) -> str | None:
    """Return the token of a request whose body is said to be JSON; None where anything is unusual."""
    known = dict(headers)
    if len(known) != len(headers) or known.get(b"content-type") != b"application/json":
        return None
    return bearer_of(known.get(b"authorization", b"").decode("latin-1"))


async def _asked(receive: Receive, read: list[Message]) -> _Asked | None:
    """Return what a body asks for, None where it is not quite right; its messages are kept in ``read``."""
    while not read or read[-1].get("more_body", False):
        read.append(await receive())
        if read[-1]["type"] == "http.disconnect":
            return None
    body = b"".join([message.get("body", b"") for message in read])
    if b"\\" in body or any(body.count(name) > 1 for name in _QUOTED):
        return None  # it may say one thing twice, which the decoder would not tell
    try:
        asked = _decoder.decode(body)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return None
    return asked if is_name(asked.planner) else None


def _again(read: list[Message], receive: Receive) -> Receive:
    """Return what hands out first what was read already."""
    waiting = deque(read)

    async def again() -> Message:
        return waiting.popleft() if waiting else await receive()

    return again
