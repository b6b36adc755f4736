"""Routes of a robot's URDF, which is validated and then stored byte for byte."""

from typing import Any

from fastapi import APIRouter, HTTPException, Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from endpoints.rest.dependencies import Administered, Looked, Provided
from endpoints.rest.media_types import is_format, media_type_of
from endpoints.rest.openapi import BODY, KNOWN, Responses, problems
from endpoints.rest.robots.clone_faults import check_clone
from endpoints.rest.robots.schemas import UrdfAnswer
from endpoints.services.services import Services
from ppaas.robot_model.describe import describe
from ppaas.robot_model.description import RobotDescription

router = APIRouter(prefix="/robots/{robot_id}/urdf", tags=["robots"])

XML = "application/xml"

_CONTENT: dict[str, Any] = {XML: {"schema": {"type": "string", "format": "binary"}}}
_NEW: Responses = {201: {"model": UrdfAnswer, "description": "The robot had no URDF before"}}
_FILE: Responses = {200: {"description": "The file, byte for byte", "content": _CONTENT}}
_SAFE = {"X-Content-Type-Options": "nosniff", "Content-Security-Policy": "sandbox"}
"""Headers that keep a browser from running scripts in a URDF of another user."""


@router.put(
    "",
    response_model=UrdfAnswer,
    responses=_NEW | KNOWN | BODY | problems(403, 404, 429),
    openapi_extra={"requestBody": {"required": True, "content": _CONTENT}},
)
async def put_urdf(robot: Administered, request: Request, services: Provided, response: Response) -> RobotDescription:
    """Set or replace the URDF of a robot, and return what was read from it.

    Footprint and velocity limits from it are used as soon as the robot connects again.
    """
    kind = media_type_of(request)
    if not (kind == "text/xml" or is_format(kind, "xml")):
        raise HTTPException(415, f"send XML with the header 'Content-Type: {XML}'")
    urdf = await request.body()
    described = await run_in_threadpool(describe, urdf)
    await check_clone(services, robot.record, urdf)
    if await services.usage.in_turn(robot.user, _put, services, robot.user, robot.id, urdf):
        response.status_code = 201
    return described


@router.get("", response_class=Response, responses=_FILE | KNOWN | problems(403, 404))
async def fetch_urdf(robot: Looked, services: Provided) -> Response:
    """Return the URDF of a robot, byte for byte."""
    urdf = await run_in_threadpool(services.store.urdf, robot.user, robot.id)
    file_name = {"Content-Disposition": f'attachment; filename="{robot.id}.urdf"'}
    return Response(urdf, media_type=XML, headers=_SAFE | file_name)


@router.delete("", status_code=204, responses=KNOWN | problems(403, 404))
async def remove_urdf(robot: Administered, services: Provided) -> None:
    """Remove the URDF of a robot; the robot then has the properties of its model."""
    await services.usage.in_turn(robot.user, _remove, services, robot.user, robot.id)


def _put(services: Services, user: str, robot_id: str, urdf: bytes) -> bool:
    with services.usage.new_urdf(services, user, robot_id, len(urdf)):
        return services.store.put_urdf(user, robot_id, urdf)


def _remove(services: Services, user: str, robot_id: str) -> None:
    services.store.remove_urdf(user, robot_id)
    services.usage.stored.forget_urdf(user, robot_id)
