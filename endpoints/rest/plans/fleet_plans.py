"""Route of plans for fleets: paths of many robots on a map that keep out of each other's way."""

from typing import Annotated, Self

import msgspec
from fastapi import APIRouter
from pydantic import Field, StrictInt, model_validator
from starlette.responses import Response

from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.plans.planning import check_timeout
from endpoints.rest.schemas import Labels, Number, Pose, RequestBody, ResponseBody
from endpoints.rest.strict_json import StrictRoute
from engine.control.planning.requests import DEFAULT_MARGIN, DEFAULT_SPEED, FleetRequest
from engine.specs.containers import MapVersion
from ppaas.decoding import converted

MAX_ROBOTS = 2000
"""Largest number of robots of a plan."""

MAX_SECONDS = 10.0
"""Longest time in which a plan is improved [s]."""

MAX_SEED = (1 << 31) - 1

LEAST_SPEED = 1e-3
"""Least speed of robots [m/s]."""

MAX_TURN = 1000.0
"""Longest time of a quarter turn [s]."""

LONGEST = 1000.0
"""Largest radius and margin [m], and largest speed [m/s]."""

router = APIRouter(tags=["plans"], route_class=StrictRoute)

Ends = Annotated[list[Pose], Field(max_length=MAX_ROBOTS, fail_fast=True)]
Speed = Annotated[Number, Field(ge=LEAST_SPEED, le=LONGEST)]


class FleetFile(RequestBody):
    """Request for a plan of a fleet."""

    starts: Ends = Field(description="One a robot, no two in one cell")
    goals: Ends = Field(description="One a robot, in the order of the starts, no two in one cell")
    radius: Annotated[Number, Field(gt=0.0, le=LONGEST)] = Field(description="Radius of the robots [m]")
    margin: Annotated[Number, Field(ge=0.0, le=LONGEST)] = Field(
        DEFAULT_MARGIN, description="Distance by which robots may stray from their paths [m]"
    )
    speed: Speed = Field(DEFAULT_SPEED, description="Speed of the robots [m/s]")
    speeds: Annotated[list[Speed], Field(max_length=MAX_ROBOTS, fail_fast=True)] | None = Field(
        None, description="Speed of each robot [m/s], in the order of the starts, instead of `speed`"
    )
    turn_seconds: Annotated[Number, Field(ge=0.0, le=MAX_TURN)] = Field(
        0.0, description="Time of a quarter turn [s]; a robot's first direction is free"
    )
    seconds: Annotated[Number, Field(ge=0.0, le=MAX_SECONDS)] = Field(
        0.0, description="Time in which the first plan is improved [s]; the time limit ends it, too"
    )
    seed: Annotated[StrictInt, Field(ge=0, le=MAX_SEED)] = Field(0, description="Seed of the random numbers")
    timeout: Annotated[Number, Field(gt=0.0)] | None = Field(None, description="Time limit of the whole request [s]")
    labels: Labels = Field({})

    @model_validator(mode="after")
    def _has_one_speed_a_robot(self) -> Self:
        if self.speeds is None:
            return self
        if "speed" in self.model_fields_set:
            raise ValueError("'speed' is that of all robots, and 'speeds' are those of each: give one of them")
        if len(self.speeds) != len(self.starts):
            raise ValueError(f"there are {len(self.speeds)} speeds and {len(self.starts)} starts; give one a robot")
        return self


class FleetPlanAnswer(ResponseBody):
    """Paths of many robots that keep out of each other's way, in steps of the same duration."""

    paths: list[list[list[float]]] = Field(
        description="A path for each robot: x, y [m] of the centre of its cell at each step. The first is the centre "
        "nearest to its start, the last that nearest to its goal"
    )
    times: list[list[float]] = Field(
        description="The times at which each robot reaches the places of its path [s], if each moves into a cell only "
        "when the robot before has reached its next one. A place at which it waits has the same time again"
    )
    spacing: float = Field(description="Distance of the centres of neighbouring cells [m]")
    step_seconds: float = Field(description="Duration of a step of the slowest robot [s]")
    cost: int = Field(description="Sum of the last arrivals of all robots at their goals [steps]")
    bound: int = Field(description="Sum of the lengths of shortest paths, below which no cost is [steps]")
    makespan: int = Field(description="Last arrival of all: a path has one place more [steps]")
    turns: int = Field(description="Number of quarter turns of all robots")
    seconds: float = Field(description="Computing time [s]")
    map: str
    version: str
    container: str
    pid: int


@router.post(
    "/maps/{map_id}/fleet_plans",
    response_model=FleetPlanAnswer,
    responses=KNOWN | BODY | problems(404, 409, 429),
)
async def plan_fleet(map_id: MapId, file: FleetFile, services: Provided, user: Caller) -> Response:
    """Return paths of up to 2000 robots that keep out of each other's way; it counts as a path for each robot."""
    request = converted(file.model_dump(exclude_none=True), FleetRequest)
    check_timeout(request.timeout, services.limits)
    await services.cloud.count_paths(user.id, max(len(request.starts), 1))
    head = await readable_head(services, user, map_id)
    answer = await services.cloud.planning.plan_fleet(user.id, MapVersion(head.id, head.version), request)
    return Response(msgspec.json.encode(answer), media_type="application/json")
