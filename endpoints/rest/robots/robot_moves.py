"""Route of moves: a robot that was brought to another map goes on there, in the same session."""

from typing import Annotated

from fastapi import APIRouter
from msgspec.structs import replace
from pydantic import ConfigDict, Field
from starlette.concurrency import run_in_threadpool

from endpoints.resources.services import Services
from endpoints.rest.dependencies import Administered, AnyCaller, Provided, readable_head
from endpoints.rest.names import Name
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.robots.schemas import RobotAnswer
from endpoints.rest.schemas import Pose, RequestBody, triple
from endpoints.rest.strict_json import StrictRoute
from engine.specs.robot_places import robot_place, urdf_of
from ppaas.errors import InvalidParameter
from ppaas.maps.new_map import new_map_id
from ppaas.nodes.map_server.costmap_filters import filter_masks
from storage.records import RobotRecord

router = APIRouter(prefix="/robots/{robot_id}", tags=["robots"], route_class=StrictRoute)


class MoveRequest(RequestBody):
    """Where a robot is now."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"map": "hotel-2", "pose": [4.0, 1.5, 1.57]}]})

    map: Annotated[Name, Field(description="Id of the map that it is on now")]
    pose: Pose


@router.post("/move", response_model=RobotAnswer, responses=KNOWN | BODY | problems(403, 404, 409, 503))
async def move_robot(robot: Administered, request: MoveRequest, services: Provided, user: AnyCaller) -> RobotRecord:
    """Report that a robot is on another map, or elsewhere on its map: the map and the initial pose in its file change.

    A connected robot keeps its session, subscriptions and stops. Its clone is replaced by one on the map, within a
    moment in which the robot stands still. Goals on the map before are cancelled.
    """
    before = robot.record
    if new_map_id(before.map) is not None:
        raise InvalidParameter("a robot that makes a map cannot be moved: change its file, and connect it again")
    await readable_head(services, user, request.map)
    _check_masks(before, request.map)
    after = replace(before, map=request.map, initial_pose=triple(request.pose))
    await run_in_threadpool(_store, services, before, after)
    await services.cloud.moves.moved(robot.user, robot.id)
    return after


def _check_masks(robot: RobotRecord, map_id: str) -> None:
    masks = filter_masks(robot.parameters)
    if masks and map_id != robot.map:
        raise InvalidParameter(
            f"the parameters of robot {robot.id!r} name masks of map {robot.map!r} ({', '.join(sorted(masks))}), which "
            "do not fit another map: draw zones on the maps instead, which each have their own"
        )


def _store(services: Services, before: RobotRecord, after: RobotRecord) -> None:
    """Store a robot that has moved, if its clone can be built there; it must not have been changed meanwhile."""
    robot_place(services.map_store, after, urdf_of(services.store, after.user, after.id))
    services.store.put_robot(after, instead_of=before)
