"""Traffic of the caller's robots on a map: who drives, who waits, and who is taken out. Its JSON schemas and routes."""

from fastapi import APIRouter
from pydantic import Field

from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId, RobotId
from endpoints.rest.openapi import KNOWN, problems
from endpoints.rest.schemas import ResponseBody
from ppaas.messages.fleet.traffic import MapPoint, TrafficRobot, TrafficState

Point = tuple[float, float]


class TrafficRobotAnswer(ResponseBody):
    """Robot that takes part in the traffic of a map."""

    robot: str
    state: str = Field(
        description="`driving`, `waiting`, `idle`, `free`, `stopped`, `stray`, `by_hand`, `held`, `docking`, `docked`, "
        "`silent`, `no_cells` or `out`"
    )
    pose: tuple[float, float, float] = Field(description="x, y [m], yaw [rad]")
    way: list[Point] = Field(description="Cells that it holds, x, y [m], in the order in which it passes them")
    waits_for: str = Field(description="Why it waits or has no cells; empty if it does not")
    goal_id: str = Field(description="Goal that it drives to; empty if it has none")
    goal: Point | None = Field(description="x, y [m]; null if it has none")
    waited: float = Field(description="Time for which it has waited [s]")

    @classmethod
    def of(cls, robot: TrafficRobot) -> "TrafficRobotAnswer":
        """Return a robot as JSON."""
        return cls(
            robot=robot.robot,
            state=robot.state,
            pose=(robot.x, robot.y, robot.theta),
            way=[_point(point) for point in robot.way],
            waits_for=robot.waits_for,
            goal_id=robot.goal_id,
            goal=_point(robot.goal) if robot.goal_id else None,
            waited=robot.waited,
        )


class TrafficAnswer(ResponseBody):
    """Traffic of the caller's robots on a map."""

    map: str
    at: float = Field(description="Time of the positions [s since the epoch]")
    spacing: float = Field(description="Distance of neighbouring cells [m]; 0 before there is a robot")
    robots: list[TrafficRobotAnswer]
    goals: int = Field(description="Number of goals that robots have reached since the traffic node began")
    seconds: float = Field(description="Time for which the traffic node has planned since then [s]")

    @classmethod
    def of(cls, map_id: str, state: TrafficState) -> "TrafficAnswer":
        """Return the traffic of a map as JSON."""
        return cls(
            map=map_id,
            at=state.header.stamp.seconds(),
            spacing=state.spacing,
            robots=[TrafficRobotAnswer.of(robot) for robot in state.robots],
            goals=state.goals,
            seconds=state.seconds,
        )


def _point(point: MapPoint) -> Point:
    return point.x, point.y


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
