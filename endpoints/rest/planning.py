"""Paths asked for: the request that is asked most often, and waited for by robots."""

import re
import uuid
from typing import Any

import msgspec
import numpy as np
from fastapi import APIRouter, Request
from msgspec import Raw
from pydantic import TypeAdapter, ValidationError
from starlette.responses import Response
from starlette.routing import BaseRoute, Match
from starlette.types import Message, Receive, Scope, Send

from endpoints.auth import authenticate
from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.plans import json_response
from endpoints.rest.schemas import NewPlanAnswer, PlanFile, triple
from endpoints.rest.strict_json import StrictRoute, is_json, parse
from endpoints.settings import Settings
from engine.model import MapVersion
from engine.views import PathAnswer, PathRequest
from ppaas.clock import epoch
from ppaas.errors import InvalidParameter
from storage.records import MapRecord, PlanRecord, User

_LEFT = "ppaas.left"
"""Key of a scope that was left to FastAPI."""

_map_id: TypeAdapter[str] = TypeAdapter(MapId)


class DirectPlans(BaseRoute):
    """Serves a request that is right before FastAPI looks for what serves it and for what that needs.

    FastAPI takes a millisecond for it. Whatever is wrong with a request, it is left to say.

    Parameters
    ----------
    prefix : str
        Of the paths of the service.
    """

    def __init__(self, prefix: str) -> None:
        self._path = re.compile(f"{re.escape(prefix)}/maps/([^/]+)/plans")

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """Tell whether a request is for a path, and was not left to FastAPI."""
        if scope["type"] != "http" or scope["method"] != "POST" or _LEFT in scope:
            return Match.NONE, {}
        found = self._path.fullmatch(scope["path"])
        return (Match.NONE, {}) if found is None else (Match.FULL, {"path_params": {"map_id": found[1]}})

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request."""
        request = Request(scope, receive)
        router, left = request.app.router, {**scope, _LEFT: True}
        if not is_json(request.headers.get("content-type", "")):
            await router(left, receive, send)
            return
        body = await request.body()
        try:
            map_id = _map_id.validate_python(request.path_params["map_id"])
            file = PlanFile.model_validate(parse(body))
        except ValidationError:
            await router(left, _again(body), send)
            return
        services = request.app.state.services
        response = await make_plan(map_id, file, services, await authenticate(request, services.accounts))
        await response(scope, receive, send)


def _again(body: bytes) -> Receive:
    """Return what hands a body out that was read already."""

    async def receive() -> Message:
        return {"type": "http.request", "body": body, "more_body": False}

    return receive


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
        timeout=_timeout(file, services.settings),
    )
    answer = await services.cloud.compute_path(user, MapVersion(head.id, head.version), request)
    plan_id = uuid.uuid4().hex
    await services.plan_keeper.keep(services.store, lambda: _record(plan_id, user, head, request, answer))
    return json_response(_told(plan_id, head, answer), status=201)


def _timeout(file: PlanFile, settings: Settings) -> float:
    if file.timeout is None:
        return settings.default_plan_seconds
    if file.timeout > settings.max_plan_seconds:
        raise InvalidParameter(f"timeout: a planner is given {settings.max_plan_seconds:g} s at most")
    return file.timeout


def _told(plan_id: str, head: MapRecord, answer: PathAnswer) -> dict[str, Any]:
    fields = {name: getattr(answer, name) for name in PathAnswer.__struct_fields__}
    return fields | {"plan_id": plan_id, "poses": Raw(answer.poses), "map": head.id, "version": head.version}


def _record(plan_id: str, user: User, head: MapRecord, request: PathRequest, answer: PathAnswer) -> PlanRecord:
    return PlanRecord(
        id=plan_id,
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
    )
