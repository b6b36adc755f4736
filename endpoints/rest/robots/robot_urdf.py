"""Check of a robot before its file or URDF is stored; routes of the URDF, which is stored byte for byte."""

from typing import Any

from fastapi import APIRouter, HTTPException, Request
from msgspec.structs import replace
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from endpoints.resources.services import Services
from endpoints.rest.dependencies import Administered, Looked, Provided
from endpoints.rest.openapi import BODY, KNOWN, Responses, problems
from endpoints.rest.robots.schemas import UrdfAnswer
from endpoints.rest.strict_json import is_format, media_type_of
from engine.specs.clone_to_check import CloneToCheck
from engine.specs.robot_places import robot_config, robot_place
from ppaas.errors import InvalidParameter, InvalidRobot, RobotFault
from ppaas.maps.formats.map_yaml import parse_yaml
from ppaas.maps.new_map import new_map_id
from ppaas.robot_model.describe import describe
from ppaas.robot_model.description import RobotDescription
from storage.ports import MapStore
from storage.records import RobotRecord
from storage.versions import YAML

BLANK_RESOLUTION = 0.05
"""Edge of the cells for a robot that makes its map [m]; its parameters set another."""


async def check_clone(services: Services, record: RobotRecord, urdf: bytes | None) -> None:
    """Refuse a robot that could not connect.

    Parameters
    ----------
    services : Services
        Without a checker of clones, only what the stores say is checked.
    record : RobotRecord
        The robot as it would be stored.
    urdf : bytes, optional
        Its URDF.

    Raises
    ------
    InvalidRobot
        The place of the robot or its clone refuses parts of the file; all that were found are listed.
    NotFound, NotPermitted, InvalidMap
        As of ``robot_place``.
    Unavailable
        The check is not possible now.
    """
    said = []
    try:
        config = (await run_in_threadpool(robot_place, services.map_store, record, urdf)).config
    except InvalidParameter as error:
        said, config = [RobotFault("parameters", str(error))], robot_config(record, urdf)
    found = []
    if services.clones is not None:
        resolution = await run_in_threadpool(_resolution, services.map_store, record.map)
        found = await services.clones.faults(CloneToCheck(replace(config, urdf_text=b""), resolution))
    found_texts = {fault.text for fault in found}
    faults = [*(fault for fault in said if fault.text not in found_texts), *found]
    if faults:
        raise InvalidRobot(faults)


def _resolution(maps: MapStore, name: str) -> float:
    if new_map_id(name) is not None:
        return BLANK_RESOLUTION
    with maps.open_map(name, only=(YAML,)) as opened:
        return parse_yaml(opened.paths[YAML].read_bytes()).resolution


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
