"""The JSON of the REST service: what is taken is checked here, what is given is described here."""

import json
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StrictBool

from endpoints.rest.names import Name, PluginName
from engine.specs.machine_settings import MOST_LABELS
from storage.records import PlanOrigin

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
MAX_COORDINATE = 1e9
"""Further than any map reaches, and near enough to reckon with."""

Pose = Annotated[
    list[Annotated[Number, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]],
    Field(min_length=2, max_length=3, description="x [m], y [m] and, if it matters, yaw [rad] in the frame of the map"),
]
Triple = Annotated[list[float], Field(min_length=3, max_length=3, description="x [m], y [m], yaw [rad]")]

MAX_PARAMETERS = 1 << 16
MAX_CORES = 1024.0


def triple(pose: list[float]) -> tuple[float, float, float]:
    """Return x, y, yaw of a pose that may come without its yaw."""
    x, y, *rest = pose
    return x, y, rest[0] if rest else 0.0


def _plain(value: dict[str, Any]) -> dict[str, Any]:
    try:
        length = len(json.dumps(value, allow_nan=False))
    except (ValueError, RecursionError) as error:
        raise ValueError("what is in it must be finite and not deeply nested") from error
    if length > MAX_PARAMETERS:
        raise ValueError(f"it may have {MAX_PARAMETERS} characters of JSON, not {length}")
    return value


class _Body(BaseModel):
    model_config = ConfigDict(extra="forbid")


class _Answer(BaseModel):
    model_config = ConfigDict(from_attributes=True)


class Fault(BaseModel):
    """One of the things that are wrong with a request."""

    where: list[str] = Field(description="The way to it: `body`, `query` or `path`, and the names on the way")
    what: str


class Problem(BaseModel):
    """What went wrong (RFC 9457)."""

    type: str = Field(examples=["urn:ppaas:problem:goal-occupied"])
    title: str
    status: int
    detail: str = Field(description="What is wrong, and what to do about it")
    code: int | None = Field(None, description="Of planning errors: that of Nav2's ComputePathToPose, 201–208")
    errors: list[Fault] | None = Field(None, description="Of invalid requests: all that is wrong")


# -- tokens ------------------------------------------------------------------------------------------------------------


class Credentials(_Body):
    """What to log in with."""

    user: str = Field(max_length=64, examples=["ann"])
    password: str = Field(max_length=1024, examples=["correct horse"])


class TokenAnswer(_Answer):
    """A login."""

    id: str = Field(description="With which it is revoked")
    token: str
    expires: float = Field(description="Seconds since the epoch")


class TokenSummary(_Answer):
    """A login, without the token itself: that is not kept."""

    id: str
    created: float = Field(description="Seconds since the epoch; 0 where it was not noted")
    expires: float = Field(description="Seconds since the epoch")
    current: bool = Field(description="Whether it is the one that is used now")


# -- maps --------------------------------------------------------------------------------------------------------------


MAX_READERS = 256
MAX_DESCRIPTION = 1000

Reader = Annotated[Literal["*"] | Name, Field(union_mode="left_to_right")]
Description = Annotated[str, Field(max_length=MAX_DESCRIPTION)]


# -- robots ------------------------------------------------------------------------------------------------------------


Cores = Annotated[Number, Field(gt=0.0, le=MAX_CORES, description="Size of its container")]
Properties = Annotated[
    dict[str, Any], AfterValidator(_plain), Field(description="Whatever else there is to say, kept as it is")
]
Parameters = Annotated[dict[str, Any], AfterValidator(_plain), Field(description="Of the clone's nodes, by node")]
Labels = Annotated[
    dict[Name, Name],
    Field(max_length=MOST_LABELS, description="Those that its machine must have", examples=[{"zone": "hall-2"}]),
]


class RobotFile(_Body):
    """The JSON file of a robot."""

    map: Name = Field(examples=["office"])
    model: Name = "turtlebot2"
    initial_pose: Pose = [0.0, 0.0, 0.0]
    cores: Cores = 1.0
    base_global_planner: PluginName = "dijkstra"
    base_local_planner: PluginName = "dwa"
    parameters: Parameters = {}
    description: Description = ""
    properties: Properties = {}
    labels: Labels = {}


class RobotChange(_Body):
    """What is to change of a robot (JSON merge patch): what is left out stays, and null stands for the default."""

    map: Name | None = None
    model: Name | None = None
    initial_pose: Pose | None = None
    cores: Cores | None = None
    base_global_planner: PluginName | None = None
    base_local_planner: PluginName | None = None
    parameters: Parameters | None = None
    description: Description | None = None
    properties: Properties | None = None
    labels: Annotated[dict[Name, Name | None], Field(max_length=MOST_LABELS)] | None = None


class RobotAnswer(_Answer):
    """A robot."""

    id: str
    user: str
    map: str
    model: str
    initial_pose: Triple
    cores: float
    base_global_planner: str
    base_local_planner: str
    parameters: dict[str, Any]
    description: str
    properties: dict[str, Any]
    labels: dict[str, str]


class SensorAnswer(_Answer):
    """A link that is a sensor."""

    link: str
    kind: str = Field(description="laser, camera, depth, or what the URDF calls it")
    pose: list[float] = Field(description="x, y, z [m], roll, pitch, yaw [rad] in the base frame")


class UrdfAnswer(_Answer):
    """What a URDF tells of a robot; null where it cannot be told."""

    name: str
    base_frame: str
    links: int
    footprint: list[tuple[float, float]] = Field(description="Corners of the convex outline from above, x, y [m]")
    circumscribed_radius: float | None = Field(description="Of the disc around the base frame that holds it [m]")
    inscribed_radius: float | None = Field(description="Of the largest disc around the base frame within it [m]")
    height: float | None = Field(description="From the ground to its top [m]")
    max_vel_x: float | None = Field(description="What its wheels allow [m/s]")
    max_vel_theta: float | None = Field(description="What its wheels allow on the spot [rad/s]")
    sensors: list[SensorAnswer]
    warnings: list[str] = Field(description="What could not be told, and why")


class RobotDetail(RobotAnswer):
    """A robot, with what its URDF tells."""

    urdf: UrdfAnswer | None


# -- health ------------------------------------------------------------------------------------------------------------


class StoreHealth(_Answer):
    """Whether a store answers."""

    state: Literal["ok", "away"]
    reason: str | None = Field(description="Why it does not, for administrators")


class HealthAnswer(_Answer):
    """How the cloud does."""

    status: Literal["ok", "degraded"]
    store: StoreHealth = Field(description="Of all but maps")
    map_store: StoreHealth
    plans_waiting: int = Field(description="Paths that wait on the disk for the store to come back")


# -- containers --------------------------------------------------------------------------------------------------------


class PinnedMap(_Answer):
    """A map, and the version of it that a container has."""

    id: str
    version: str


class ContainerAnswer(_Answer):
    """A container."""

    id: str
    kind: Literal["robot", "planning"]
    user: str
    robot: str | None
    map: PinnedMap
    machine: str
    cores: float
    state: Literal["starting", "ready"]
    pid: int | None
    pss: int | None = Field(description="Proportional set size [bytes]")
    ready_seconds: float | None = Field(description="From the order to start it until it answered [s]")
    cpu: float | None = Field(description="CPU in use, in cores, once it was measured")
    age: float = Field(description="Since the order to start it [s]")
    clients: int = Field(description="Sockets of the robot and its operators")
    round_trip: float | None = Field(description="To the robot, once it was measured [s]")


# -- plans -------------------------------------------------------------------------------------------------------------


class PlanFile(_Body):
    """A path that is asked for."""

    start: Pose
    goal: Pose
    planner: PluginName = "dijkstra"
    tolerance: Annotated[Number, Field(ge=0.0, description="How far off the goal will do, if it is blocked [m]")] = 0.0
    timeout: Annotated[Number, Field(gt=0.0)] | None = Field(None, description="Time allowed to the planner [s]")
    reuse: StrictBool = Field(True, description="Whether a kept path will do where it comes sooner than a new one")
    queue: StrictBool = Field(False, description="Whether to wait for a turn (202) where there is no container now")
    labels: Labels = {}


class CostFile(_Body):
    """Costs that are asked for."""

    starts: Annotated[list[Pose], Field(max_length=1000)]
    goals: Annotated[list[Pose], Field(max_length=1000)]
    timeout: Annotated[Number, Field(gt=0.0)] | None = Field(None, description="Time allowed to all of it [s]")
    labels: Labels = {}


class CostMatrixAnswer(_Answer):
    """What it costs to get from each start to each goal."""

    costs: list[list[float | None]] = Field(description="A row for each start; null where no way leads to the goal")
    seconds: float = Field(description="Time it took [s]")
    map: str
    version: str
    container: str
    pid: int


class PlanSummary(_Answer):
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


class _Path(_Answer):
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
