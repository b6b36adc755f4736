"""Routes of the traffic of the caller's robots on a map: who drives, who waits, and who is taken out."""

from fastapi import APIRouter

from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId, RobotId
from endpoints.rest.openapi import KNOWN, problems
from endpoints.rest.traffic.schemas import TrafficAnswer

router = APIRouter(prefix="/maps/{map_id}/traffic", tags=["traffic"])


@router.get("", response_model=TrafficAnswer, responses=KNOWN | problems(404))
async def show_traffic(map_id: MapId, services: Provided, user: Caller) -> TrafficAnswer:
    """Show the traffic of the caller's robots on a map: what each holds, where it wants to go, and for whom it waits.

    Unavailable (503) while none of them takes part: register one with `"traffic": true`, and connect it.
    """
    await readable_head(services, user, map_id)
    return TrafficAnswer.of(map_id, await services.cloud.traffic.state(user.id, map_id))


@router.post("/robots/{robot}/take_out", status_code=204, responses=KNOWN | problems(404, 409))
async def take_out_robot(map_id: MapId, robot: RobotId, services: Provided, user: Caller) -> None:
    """Take a robot of the caller out of the traffic, as one that has broken down: others drive where it stood.

    See to it first that it is out of the way, or is avoided: what it held is free from then on.
    """
    await readable_head(services, user, map_id)
    await services.cloud.traffic.take_out(user.id, map_id, robot)


@router.post("/robots/{robot}/put_back", status_code=204, responses=KNOWN | problems(404, 409))
async def put_back_robot(map_id: MapId, robot: RobotId, services: Provided, user: Caller) -> None:
    """Put a robot of the caller back into the traffic, where it now stands."""
    await readable_head(services, user, map_id)
    await services.cloud.traffic.put_back(user.id, map_id, robot)
