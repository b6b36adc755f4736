"""Paths asked for: the request that is asked most often, and waited for by robots."""

import asyncio
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any

import msgspec
import numpy as np
from fastapi import APIRouter
from msgspec import Raw
from pydantic import BaseModel, Field
from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, Responses, problems
from endpoints.rest.plans.schemas import NewPlanAnswer, PlanFile
from endpoints.rest.schemas import triple
from endpoints.rest.strict_json import StrictRoute
from endpoints.services.request_limits import Settings
from endpoints.services.services import Services
from engine.service.path_requests import PathAnswer, PathRequest
from engine.specs.containers import MapVersion
from ppaas.clock import epoch
from ppaas.errors import InvalidParameter
from storage.records import MapRecord, PlanRecord, User

router = APIRouter(tags=["plans"], route_class=StrictRoute)


class QueueAnswer(BaseModel):
    """It waits for its turn: ask the same again after `Retry-After` seconds, or it leaves the queue."""

    position: int = Field(description="In the queue, the first being 1")
    detail: str


_WAITS: Responses = {202: {"model": QueueAnswer, "description": "It waits for its turn, as was asked for"}}


@router.post(
    "/maps/{map_id}/plans",
    status_code=201,
    response_model=NewPlanAnswer,
    responses=_WAITS | KNOWN | BODY | problems(404, 409, 429),
)
async def make_plan(map_id: MapId, file: PlanFile, services: Provided, user: Caller) -> Response:
    """Plan a path on a map, and keep it; with `queue`, in turn where there is no container for it now (202)."""
    asked = PathRequest(
        start=triple(file.start),
        goal=triple(file.goal),
        planner=file.planner,
        tolerance=file.tolerance,
        timeout=allowed_timeout(file.timeout, services.settings),
        reuse=file.reuse,
        queue=file.queue,
        labels=file.labels,
    )
    return await plan_and_keep(services, user, map_id, asked)


async def plan_and_keep(services: Services, user: User, map_id: str, asked: PathRequest) -> "PlanResponse":
    """Return the path that a container plans, which is kept when it was told."""
    services.cloud.quotas.learn(user)
    services.cloud.plan_rate.take(user.id)
    head = await readable_head(services, user, map_id)
    answer = await services.cloud.compute_path(user, MapVersion(head.id, head.version), asked)
    keep = None
    if answer.plan_id != answer.reused:  # else it is kept already
        keep = partial(services.plan_keeper.keep, services.store, partial(_record, user, head, asked, answer))
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
        super().__init__(status_code=201, headers={})
        self.body = body
        # As they are sent: to have them made of a dict takes longer than to make the body.
        self.raw_headers = [(b"content-length", b"%d" % len(body)), (b"content-type", b"application/json")]
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
