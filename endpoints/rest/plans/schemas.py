"""JSON schemas of planning: path and cost requests, their responses, and the Path Plan Database."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, Field, StrictBool

from endpoints.rest.names import MapId, PluginName
from endpoints.rest.schemas import FreeForm, Labels, Number, Pose, RequestBody, ResponseBody, Triple
from ppaas.plans.path_service import MAX_COORDINATE
from ppaas.plans.stored import LARGEST_TOLERANCE
from storage.records import PlanOrigin

MAX_WAYPOINTS = 1 << 14
"""Largest number of poses in a request; the size of its body is limited too."""

MAX_MATRIX = 1000
"""Largest number of starts, and of goals, of a cost matrix."""

MAX_FOUND = 100
"""Largest number of paths that a search returns."""

# fail_fast: one error of a long list is enough, and a list of 100,000 errors would block all other requests.
Poses = Annotated[list[Pose], Field(max_length=MAX_MATRIX, fail_fast=True)]
Row = Annotated[
    list[Annotated[Number, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]], Field(min_length=7, max_length=7)
]
Rows = Annotated[list[Row], Field(min_length=1, max_length=MAX_WAYPOINTS, fail_fast=True)]


def _place(text: str) -> str:
    place_of(text)
    return text


def place_of(text: str) -> tuple[float, float]:
    """Return the x, y of a text such as ``2,-3.5``.

    Raises
    ------
    ValueError
        The text is not a place; the message describes the expected form.
    """
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError as error:
        raise ValueError("a place must be x,y in metres, such as 2,-3.5") from error
    if not max(abs(x), abs(y)) <= MAX_COORDINATE:
        raise ValueError(f"x and y must be between -{MAX_COORDINATE:g} and {MAX_COORDINATE:g}")
    return x, y


Place = Annotated[str, AfterValidator(_place), Field(max_length=64, examples=["2,-3.5"])]


class PlanFile(RequestBody):  # describes the fields; ppaas.plans.path_service.PathRequest decodes them
    """Request for a path."""

    start: Pose
    goal: Pose
    planner: PluginName = "dijkstra"
    tolerance: Annotated[
        Number,
        Field(ge=0.0, description="If the goal is blocked, plan to the nearest free cell within this distance [m]"),
    ] = 0.0
    timeout: Annotated[Number, Field(gt=0.0)] | None = Field(None, description="Time limit of the planner [s]")
    reuse: StrictBool = Field(
        True, description="Whether a stored path may be returned if it is available sooner than a new one"
    )
    queue: StrictBool = Field(False, description="Whether to wait in the queue (202) if no container is available now")
    labels: Labels = Field({})
    parameters: FreeForm = Field(
        {},
        description="Parameters of the planner and of the global costmap that differ from the usual ones, as in a "
        "robot's file: `allow_unknown`, `inflation_radius`, `cost_scaling_factor`, `lethal_cost_threshold`, "
        "`robot_radius`, `footprint`, and the planner's own",
        examples=[{"allow_unknown": False, "inflation_radius": 0.3}],
    )


class CostFile(RequestBody):
    """Request for a cost matrix."""

    starts: Poses
    goals: Poses
    timeout: Annotated[Number, Field(gt=0.0)] | None = Field(None, description="Time limit of the whole request [s]")
    labels: Labels = Field({})
    parameters: FreeForm = Field(
        {},
        description="`allow_unknown`, and parameters of the global costmap, as for a path",
        examples=[{"allow_unknown": False, "robot_radius": 0.3}],
    )


class CostMatrixAnswer(ResponseBody):
    """Costs of the cheapest paths from each start to each goal."""

    costs: list[list[float | None]] = Field(
        description="A row for each start with a cost for each goal; null if there is no path"
    )
    seconds: float = Field(description="Computing time [s]")
    map: str
    version: str
    container: str
    pid: int


class PlanSummary(ResponseBody):
    """Stored path without its poses."""

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
        description="Whether the path was computed, or made from a stored path (reused, or stitched to start and "
        "goal), or given by a program"
    )


class _Path(ResponseBody):
    plan_id: str
    poses: list[list[float]] | str = Field(
        description="x, y, z [m], qx, qy, qz, qw a row, in the frame of the map; in another form if `poses` names one"
    )
    length: float = Field(description="Along the poses [m]")
    cost: float
    seconds: float = Field(description="Time the planner took [s]")
    planner: str
    map: str
    version: str


class NewPlanAnswer(_Path):
    """New path, and the container that planned it."""

    expanded: int = Field(description="Number of cells whose value was settled")
    origin: Literal["computed", "reused", "stitched"] = Field(
        description="Whether the path was computed, or a stored path was reused or stitched to start and goal"
    )
    reused: str | None = Field(description="Id of the stored path; null if the path was computed")
    conditions: dict[str, Any] = Field(description="Conditions of the path: the planner's parameters and others")
    container: str
    pid: int


class PlanAnswer(_Path):
    """Stored path."""

    user: str
    robot: str | None
    start: Triple
    goal: Triple
    created: float = Field(description="Seconds since the epoch")


class PlanSearch(RequestBody):
    """Search for stored paths between two places."""

    map: MapId = Field(description="Map; paths on its current version are searched")
    start: Place
    goal: Place
    tolerance: float = Field(
        0.25, ge=0.0, le=LARGEST_TOLERANCE, description="Largest distance of a path's ends from start and goal [m]"
    )
    planner: PluginName | None = None
    limit: int = Field(16, ge=1, le=MAX_FOUND)


class PlanPut(RequestBody):
    """Path to store, new or in place of a stored one."""

    map: MapId
    planner: PluginName
    poses: Rows = Field(description="x, y, z [m], qx, qy, qz, qw a row, in the frame of the map")
    cost: Annotated[Number, Field(ge=0.0)] = 0.0
    seconds: Annotated[Number, Field(ge=0.0, description="Time the planner took [s]")] = 0.0
    parameters: FreeForm = Field({}, description="Parameters of the planner")


class PlanChange(PlanPut):
    """Changes of a stored path; omitted fields stay unchanged."""

    map: MapId | None = None  # type: ignore[assignment]
    planner: PluginName | None = None  # type: ignore[assignment]
    poses: Rows | None = None  # type: ignore[assignment]


class FoundPlans(ResponseBody):
    """Stored paths between two places, shortest first."""

    items: list[PlanSummary]
    next: None = None


class PartAnswer(ResponseBody):
    """Segment of a path that is stored as an entry."""

    entry: str = Field(description="Id of the entry; equal segments share one entry")
    first: int = Field(description="Index of its first waypoint in the path")
    count: int = Field(description="Number of its waypoints")
    plans: int = Field(description="Number of references from paths")


class Parts(BaseModel):
    """Segments of a path that are stored as entries, in order."""

    items: list[PartAnswer]
    next: None = None


class StatisticsAnswer(ResponseBody):
    """Storage used by the paths on a map."""

    plans: int
    waypoints: int = Field(description="Total number of waypoints of all paths")
    kept: int = Field(description="Number of waypoints stored for them")
    entries: int = Field(description="Number of entries: segments that paths share")
    bytes: int = Field(description="Storage of paths and entries, without indexes [bytes]")
