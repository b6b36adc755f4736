"""The JSON of planning: paths and costs that are asked for, and the Path Plan Database."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, Field, StrictBool

from endpoints.rest.names import MapId, PluginName
from endpoints.rest.schemas import (
    Labels,
    Number,
    Pose,
    RequestBody,
    ResponseBody,
    Triple,
    plain_json,
)
from engine.service.path_requests import MAX_COORDINATE
from ppaas.plans.stored import LARGEST_TOLERANCE
from storage.records import PlanOrigin

MAX_WAYPOINTS = 1 << 14
"""Poses that a request may bring; its body has an end too."""

MOST_FOUND = 100

Row = Annotated[
    list[Annotated[Number, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]], Field(min_length=7, max_length=7)
]


def _place(text: str) -> str:
    place_of(text)
    return text


def place_of(text: str) -> tuple[float, float]:
    """Return the x, y of a text such as ``2,-3.5``.

    Raises
    ------
    ValueError
        It is none; the text says what one is.
    """
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError as error:
        raise ValueError("a place is x,y in metres, such as 2,-3.5") from error
    if not max(abs(x), abs(y)) <= MAX_COORDINATE:
        raise ValueError(f"x and y are numbers up to {MAX_COORDINATE:g}")
    return x, y


Place = Annotated[str, AfterValidator(_place), Field(max_length=64, examples=["2,-3.5"])]


class PlanFile(RequestBody):
    """A path that is asked for."""

    start: Pose
    goal: Pose
    planner: PluginName = "dijkstra"
    tolerance: Annotated[Number, Field(ge=0.0, description="How far off the goal will do, if it is blocked [m]")] = 0.0
    timeout: Annotated[Number, Field(gt=0.0)] | None = Field(None, description="Time allowed to the planner [s]")
    reuse: StrictBool = Field(True, description="Whether a kept path will do where it comes sooner than a new one")
    queue: StrictBool = Field(False, description="Whether to wait for a turn (202) where there is no container now")
    labels: Labels = Field({})


class CostFile(RequestBody):
    """Costs that are asked for."""

    starts: Annotated[list[Pose], Field(max_length=1000)]
    goals: Annotated[list[Pose], Field(max_length=1000)]
    timeout: Annotated[Number, Field(gt=0.0)] | None = Field(None, description="Time allowed to all of it [s]")
    labels: Labels = Field({})


class CostMatrixAnswer(ResponseBody):
    """What it costs to get from each start to each goal."""

    costs: list[list[float | None]] = Field(description="A row for each start; null where no way leads to the goal")
    seconds: float = Field(description="Time it took [s]")
    map: str
    version: str
    container: str
    pid: int


class PlanSummary(ResponseBody):
    """A path that was kept, without its poses."""

    plan_id: str
    user: str
    robot: str | None
    map: str
    version: str
    planner: str
    start: Triple
    goal: Triple
    length: float = Field(description="Along the poses [m]")
    cost: float
    seconds: float = Field(description="Time the planner took [s]")
    created: float = Field(description="Seconds since the epoch")
    origin: PlanOrigin = Field(
        description="Whether it was computed, or made of a kept one: reused, or stitched to start and goal; or given "
        "by a program, whose word for what made it is not taken"
    )


class _Path(ResponseBody):
    plan_id: str
    poses: list[list[float]] = Field(description="x, y, z [m], qx, qy, qz, qw a row, in the frame of the map")
    length: float = Field(description="Along the poses [m]")
    cost: float
    seconds: float = Field(description="Time the planner took [s]")
    planner: str
    map: str
    version: str


class NewPlanAnswer(_Path):
    """A path that was just found, and where."""

    expanded: int = Field(description="Cells whose value was settled")
    origin: Literal["computed", "reused", "stitched"] = Field(
        description="Whether it was computed, or a kept path was reused, or stitched to start and goal"
    )
    reused: str | None = Field(description="Id of that kept path")
    conditions: dict[str, Any] = Field(description="Under which it was made: the parameters of the planner, and others")
    container: str
    pid: int


class PlanAnswer(_Path):
    """A path that was kept."""

    user: str
    robot: str | None
    start: Triple
    goal: Triple
    created: float = Field(description="Seconds since the epoch")


class PlanSearch(RequestBody):
    """Between which places paths are looked for."""

    map: MapId = Field(description="On whose present version they are")
    start: Place
    goal: Place
    tolerance: float = Field(0.25, ge=0.0, le=LARGEST_TOLERANCE, description="How far off an end may be [m]")
    planner: PluginName | None = None
    limit: int = Field(16, ge=1, le=MOST_FOUND)


class PlanPut(RequestBody):
    """A path that takes the place of a kept one, or is kept for the first time."""

    map: MapId
    planner: PluginName
    poses: Annotated[list[Row], Field(min_length=1, max_length=MAX_WAYPOINTS)] = Field(
        description="x, y, z [m], qx, qy, qz, qw a row, in the frame of the map"
    )
    cost: Annotated[Number, Field(ge=0.0)] = 0.0
    seconds: Annotated[Number, Field(ge=0.0, description="Time the planner took [s]")] = 0.0
    parameters: Annotated[dict[str, Any], AfterValidator(plain_json)] = Field({}, description="The planner's")


class PlanChange(PlanPut):
    """What is changed of a kept path; what is left out stays."""

    map: MapId | None = None  # type: ignore[assignment]
    planner: PluginName | None = None  # type: ignore[assignment]
    poses: Annotated[list[Row], Field(min_length=1, max_length=MAX_WAYPOINTS)] | None = None  # type: ignore[assignment]


class FoundPlans(ResponseBody):
    """Paths that were kept between two places, the shortest first."""

    items: list[PlanSummary]
    next: None = None


class PartAnswer(ResponseBody):
    """A stretch that a path shares."""

    entry: str = Field(description="Its id in the database: equal stretches have the same")
    first: int = Field(description="Its first waypoint in the path")
    count: int = Field(description="How many it has")
    plans: int = Field(description="How often paths refer to it")


class Parts(BaseModel):
    """The stretches of a path that are entries of their own, in order."""

    items: list[PartAnswer]
    next: None = None


class StatisticsAnswer(ResponseBody):
    """What the paths on a map take."""

    plans: int
    waypoints: int = Field(description="Of all paths")
    kept: int = Field(description="Waypoints that are kept for them")
    entries: int = Field(description="Stretches that paths share")
    bytes: int = Field(description="What paths and entries take, without indexes")
