"""JSON schemas of plans and costs over the floors of a building."""

from typing import Annotated, Literal

from pydantic import BaseModel, Field, StrictBool

from endpoints.rest.schemas import FreeForm, Labels, Number, RequestBody, ResponseBody, Triple
from ppaas.buildings.building import LONGEST_ID, MOST_DOORS
from ppaas.plans.path_service import MAX_COORDINATE

MOST_ALTERNATIVES = 10
"""Largest number of further routes of a plan."""

MOST_PLACES = 200
"""Largest number of starts, and of goals, of a matrix of times."""

FloorName = Annotated[str, Field(min_length=1, max_length=LONGEST_ID, description="Name of a floor")]
BuildingName = Annotated[str, Field(min_length=1, max_length=LONGEST_ID)]
Metres = Annotated[Number, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]


class FloorPlace(RequestBody):
    """Place on a floor, in the frame of its map."""

    floor: FloorName
    x: Metres = Field(description="[m]")
    y: Metres = Field(description="[m]")
    yaw: Metres = Field(0.0, description="[rad]")


class FloorDoor(RequestBody):
    """Door of a floor."""

    floor: FloorName
    door: BuildingName


class TravellingRobot(RequestBody):
    """What the robot can do."""

    speed: Annotated[Number, Field(gt=0.0, le=100.0, description="Mean speed [m/s]")] = 0.5
    labels: Labels = Field(
        default={}, description="Labels of the robot, which some ways ask for", examples=[{"legs": "4"}]
    )
    stairs: StrictBool = Field(default=False, description="Whether it climbs stairs")


class RideBegun(RequestBody):
    """Ride in a lift that the robot has begun."""

    lift: BuildingName
    floor: FloorName = Field(description="Floor at which it waits, or on which it entered the car")
    inside: StrictBool = Field(False, description="Whether it is in the car")
    to: Annotated[str, Field(max_length=LONGEST_ID, description="Floor to which the car was sent, if any")] = ""


class _BuildingRequest(RequestBody):
    robot: TravellingRobot = TravellingRobot()
    avoid: list[BuildingName] = Field([], max_length=100, description="Lifts and ways that are not taken")
    closed: list[FloorDoor] = Field([], max_length=MOST_DOORS, description="Doors that are closed")
    timeout: Annotated[Number, Field(gt=0.0)] | None = Field(None, description="Time limit of each floor [s]")
    labels: Labels = Field({}, description="Labels that the machines of the containers must have")
    parameters: FreeForm = Field(
        {},
        description="`allow_unknown`, and parameters of the global costmap, as for a path on a map",
        examples=[{"robot_radius": 0.3}],
    )


class BuildingPlanFile(_BuildingRequest):
    """Request for a plan over floors."""

    start: FloorPlace
    goal: FloorPlace
    alternatives: Annotated[
        int,
        Field(ge=0, le=MOST_ALTERNATIVES, strict=True, description="Number of further routes, by other lifts and ways"),
    ] = 0
    session: RideBegun | None = Field(
        None,
        description="Ride that the robot has begun: it is kept unless another route is clearly faster. `start` is not "
        "used if the robot is in the car",
    )
    reuse: StrictBool = Field(True, description="Whether stored paths may be returned, if that is sooner")


class BuildingCostFile(_BuildingRequest):
    """Request for the times from each of many starts to each of many goals."""

    starts: Annotated[list[FloorPlace], Field(max_length=MOST_PLACES, fail_fast=True)]
    goals: Annotated[list[FloorPlace], Field(max_length=MOST_PLACES, fail_fast=True)]


class LegAnswer(ResponseBody):
    """Part of a route."""

    kind: Literal["drive", "door", "lift", "way"]
    name: str = Field(description="Door, or id of the lift or the way; empty for a drive")
    floor: str = Field(description="Floor on which it begins")
    to_floor: str
    start: Triple = Field(description="In the frame of the map of `floor`")
    goal: Triple = Field(description="In the frame of the map of `to_floor`")
    length: float = Field(description="Distance that the robot drives [m]")
    seconds: float = Field(description="Time that it takes, waiting for a lift included [s]")
    map: str = Field("", description="Map of a drive")
    version: str = Field("", description="Version of this map")
    plan_id: str = Field("", description="Id of the path of a drive in the plan database; empty if it is not stored")
    poses: list[list[float]] = Field([], description="Path of a drive: x [m], y [m], yaw [rad] a row")


class RouteAnswer(BaseModel):
    """Route over floors."""

    seconds: float = Field(description="Time from start to goal [s]")
    length: float = Field(description="Distance that the robot drives [m]")
    takes: list[str] = Field(description="Lifts and ways, in order")
    legs: list[LegAnswer]


class BuildingPlanAnswer(RouteAnswer):
    """Best route over floors, with its paths, and further routes without paths."""

    building: int = Field(description="Version of the building")
    alternatives: list[RouteAnswer] = Field(description="Further routes, each by other lifts and ways")


class BuildingCostAnswer(BaseModel):
    """Times from each start to each goal."""

    seconds: list[list[float | None]] = Field(
        description="A row for each start with a time for each goal [s]; null if there is no route"
    )
    building: int = Field(description="Version of the building")
