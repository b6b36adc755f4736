"""Routes of paths and of cost matrices: costs of the cheapest paths from each of many starts to each of many goals.

`fast_path` calls the same function as the route of paths.
"""

import asyncio
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Annotated

import msgspec
from fastapi import APIRouter, Depends
from pydantic import BaseModel, Field
from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from endpoints.resources.services import RequestLimits, Services
from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, Responses, problems
from endpoints.rest.plans.representations import Representation, asked, described
from endpoints.rest.plans.schemas import CostFile, CostMatrixAnswer, NewPlanAnswer, PlanFile
from endpoints.rest.schemas import triple
from endpoints.rest.strict_json import StrictRoute
from engine.control.planning.requests import CostRequest
from engine.specs.containers import MapVersion
from ppaas.clock import epoch
from ppaas.decoding import converted
from ppaas.errors import InvalidParameter
from ppaas.geometry import Poses
from ppaas.plans.path_service import PathAnswer, PathRequest
from storage.records import PlanRecord, User

router = APIRouter(tags=["plans"], route_class=StrictRoute)


class QueueAnswer(BaseModel):
    """Position in the queue. Repeat the request after `Retry-After` seconds, or it leaves the queue."""

    position: int = Field(description="Position in the queue; the first is 1")
    detail: str


_UNSTORED: Responses = {
    200: {"model": NewPlanAnswer, "description": "The path is not stored, and has no id: the store takes none now"}
}
_QUEUED: Responses = {202: {"model": QueueAnswer, "description": "The request waits in the queue, as requested"}}


@router.post(
    "/maps/{map_id}/plans",
    status_code=201,
    response_model=NewPlanAnswer,
    responses=described(201) | _UNSTORED | _QUEUED | KNOWN | BODY | problems(404, 409, 429),
)
async def make_plan(
    map_id: MapId, file: PlanFile, services: Provided, user: Caller, wanted: Annotated[Representation, Depends(asked)]
) -> Response:
    """Plan a path on a map and store it. With `queue`, wait in the queue if no container is available now (202)."""
    request = converted(file.model_dump(exclude_none=True), PathRequest)
    return await plan_and_store(services, user, map_id, request, wanted)


@router.post(
    "/maps/{map_id}/cost_matrix",
    response_model=CostMatrixAnswer,
    responses=KNOWN | BODY | problems(404, 409, 429),
)
async def compute_costs(map_id: MapId, file: CostFile, services: Provided, user: Caller) -> Response:
    """Return the cost of the cheapest path from each start to each goal; at most 50000 costs per request."""
    request = converted(file.model_dump(exclude_none=True), CostRequest)
    check_timeout(request.timeout, services.limits)
    await services.cloud.count_paths(user.id, max(len(request.starts), 1))
    head = await readable_head(services, user, map_id)
    answer = await services.cloud.planning.compute_costs(user.id, MapVersion(head.id, head.version), request)
    return Response(msgspec.json.encode(answer), media_type="application/json")


async def plan_and_store(
    services: Services, user: User, map_id: str, request: PathRequest, wanted: Representation
) -> "PlanResponse":
    """Return the response with the path that a container plans; the path is stored after it was sent.

    While too many paths wait for a store that takes none, the response has status 200 and no id instead of 201.

    Raises
    ------
    InvalidParameter
        The time limit is above the service's.
    NotFound
        The map does not exist, or the user may not read it.
    QuotaExceeded
        Too many requests, or too many containers.
    PlanningError, Queued, Unavailable
        As ``Planning.compute_path``.
    """
    check_timeout(request.timeout, services.limits)
    await services.cloud.count_paths(user.id, 1)
    head = await readable_head(services, user, map_id)
    answer, poses = await services.cloud.planning.compute_path(user.id, MapVersion(head.id, head.version), request)
    fields = msgspec.structs.asdict(answer) | {"poses": poses}
    if answer.plan_id == answer.reused:  # it is stored already
        return PlanResponse(wanted.encode(fields), wanted.media_type, None)
    if not services.plan_writer.accepts:
        return PlanResponse(wanted.encode(fields | {"plan_id": ""}), wanted.media_type, None, status=200)
    store = partial(services.plan_writer.write, services.store, partial(plan_record, user, request, answer, poses))
    return PlanResponse(wanted.encode(fields), wanted.media_type, store)


class PlanResponse(Response):
    """Response with a path.

    Parameters
    ----------
    body : bytes
    media_type : str
        Media type of the body.
    store : callable, optional
        Stores the path. It runs after the response was sent, and before the next request of the connection is read.
    status : int
        HTTP status.
    """

    def __init__(
        self, body: bytes, media_type: str, store: Callable[[], Awaitable[None]] | None, status: int = 201
    ) -> None:
        super().__init__(status_code=status, headers={})
        self.body = body
        # Encoded headers: Starlette takes longer to build them from a dict than msgspec takes to encode the body.
        self.raw_headers = [(b"content-length", b"%d" % len(body)), (b"content-type", media_type.encode())]
        self._store = store

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the response, then store the path."""
        await super().__call__(scope, receive, send)
        if self._store is not None:
            await asyncio.sleep(0)  # the event loop writes the response to the socket at the end of this iteration
            await self._store()


def check_timeout(timeout: float, limits: RequestLimits) -> None:
    """Raise ``InvalidParameter`` if a planner's time limit [s] is above the service's."""
    if timeout > limits.max_plan_seconds:
        raise InvalidParameter(f"timeout must be at most {limits.max_plan_seconds:g} s, not {timeout:g} s")


def plan_record(user: User, request: PathRequest, answer: PathAnswer, poses: Poses) -> PlanRecord:
    """Return the record under which a new path is stored."""
    return PlanRecord(
        id=answer.plan_id,
        user=user.id,
        map=answer.map,
        version=answer.version,
        planner=answer.planner,
        start=triple(request.start),
        goal=triple(request.goal),
        length=answer.length,
        cost=answer.cost,
        seconds=answer.seconds,
        poses=poses.astype("<f8", copy=False).tobytes(),
        created=epoch(),
        parameters=msgspec.json.decode(answer.conditions),
        origin=answer.origin,
    )
