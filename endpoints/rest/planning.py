"""Paths asked for: the request that is asked most often, and waited for by robots."""

import asyncio
import re
from collections import deque
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any

import msgspec
import numpy as np
from fastapi import APIRouter
from msgspec import Raw
from pydantic import TypeAdapter, ValidationError
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, HTTPConnection
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from endpoints.auth import authenticate
from endpoints.problems import problem_response, unexpected
from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.schemas import NewPlanAnswer, PlanFile, triple
from endpoints.rest.strict_json import StrictRoute, is_json, parse
from endpoints.services import Services
from endpoints.settings import Settings
from engine.model import MapVersion
from engine.views import PathAnswer, PathRequest
from ppaas.clock import epoch
from ppaas.errors import InvalidParameter, PPaaSError
from storage.records import MapRecord, PlanRecord, User

_map_id: TypeAdapter[str] = TypeAdapter(MapId)


class DirectPlans:
    """ASGI middleware that serves a request for a path before all of FastAPI, if it is right.

    FastAPI takes a millisecond for it. Whatever is wrong with a request, what is behind is left to say.

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
        found = None
        if scope["type"] == "http" and scope["method"] == "POST":
            found = self._path.fullmatch(scope["path"])
        if found is None:
            await self._app(scope, receive, send)
            return
        connection, read = HTTPConnection(scope), list[Message]()
        try:
            file = await _file(connection, receive, read)
            map_id = _map_id.validate_python(found[1])
        except (ClientDisconnect, HTTPException, ValidationError):
            await self._app(scope, _again(read, receive), send)
            return
        except PPaaSError as error:
            response = problem_response(error)
        else:
            response = await self._answer(connection, map_id, file)
        await response(scope, receive, send)

    async def _answer(self, connection: HTTPConnection, map_id: str, file: PlanFile) -> Response:
        try:
            return await make_plan(
                map_id, file, self._services, await authenticate(connection, self._services.accounts)
            )
        except PPaaSError as error:
            return problem_response(error)
        except Exception:  # noqa: BLE001  # logged, and nobody stands before this to answer
            return unexpected(connection.scope)


async def _file(connection: HTTPConnection, receive: Receive, read: list[Message]) -> PlanFile:
    """Return what a body asks for; its messages are kept in ``read``."""
    if not is_json(connection.headers.get("content-type", "")):
        raise HTTPException(415)
    return PlanFile.model_validate(parse(await _body(receive, read)))


async def _body(receive: Receive, read: list[Message]) -> bytes:
    while not read or read[-1].get("more_body", False):
        read.append(await receive())
        if read[-1]["type"] == "http.disconnect":
            raise ClientDisconnect
    return b"".join(message.get("body", b"") for message in read)


def _again(read: list[Message], receive: Receive) -> Receive:
    """Return what hands out first what was read already."""
    waiting = deque(read)

    async def again() -> Message:
        return waiting.popleft() if waiting else await receive()

    return again


router = APIRouter(tags=["plans"], route_class=StrictRoute)


@router.post(
    "/maps/{map_id}/plans",
    status_code=201,
    response_model=NewPlanAnswer,
    responses=KNOWN | BODY | problems(404, 409, 429),
)
async def make_plan(map_id: MapId, file: PlanFile, services: Provided, user: Caller) -> Response:
    """Plan a path on a map, and keep it."""
    head = await readable_head(services, user, map_id)
    request = PathRequest(
        start=triple(file.start),
        goal=triple(file.goal),
        planner=file.planner,
        tolerance=file.tolerance,
        timeout=allowed_timeout(file.timeout, services.settings),
        reuse=file.reuse,
    )
    answer = await services.cloud.compute_path(user, MapVersion(head.id, head.version), request)
    keep = None
    if answer.plan_id != answer.reused:  # else it is kept already
        keep = partial(services.plan_keeper.keep, services.store, partial(_record, user, head, request, answer))
    return PlanResponse(msgspec.json.encode(_told(head, answer)), keep)


class PlanResponse(Response):
    """A path that was found.

    Parameters
    ----------
    body : bytes
        JSON.
    keep : callable, optional
        Run when the answer is on its way, and before the next request is read.
    """

    def __init__(self, body: bytes, keep: Callable[[], Awaitable[None]] | None) -> None:
        super().__init__(body, 201, media_type="application/json")
        self._keep = keep

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send it."""
        await super().__call__(scope, receive, send)
        if self._keep is not None:
            await asyncio.sleep(0)  # what was sent is written at the end of this turn of the loop
            await self._keep()


def allowed_timeout(asked: float | None, settings: Settings) -> float:
    """Return the time that a planner is given [s].

    Raises
    ------
    InvalidParameter
        More is asked for than may be.
    """
    if asked is None:
        return settings.default_plan_seconds
    if asked > settings.max_plan_seconds:
        raise InvalidParameter(f"timeout: a planner is given {settings.max_plan_seconds:g} s at most")
    return asked


def _told(head: MapRecord, answer: PathAnswer) -> dict[str, Any]:
    fields = msgspec.structs.asdict(answer)
    fields["poses"], fields["conditions"] = Raw(answer.poses), Raw(answer.conditions)
    fields["reused"] = answer.reused or None
    fields["map"], fields["version"] = head.id, head.version
    return fields


def _record(user: User, head: MapRecord, request: PathRequest, answer: PathAnswer) -> PlanRecord:
    return PlanRecord(
        id=answer.plan_id,
        user=user.id,
        map=head.id,
        version=head.version,
        planner=answer.planner,
        start=request.start,
        goal=request.goal,
        length=answer.length,
        cost=answer.cost,
        seconds=answer.seconds,
        poses=np.array(msgspec.json.decode(answer.poses), "<f8").tobytes(),
        created=epoch(),
        parameters=msgspec.json.decode(answer.conditions),
        origin=answer.origin,
    )
