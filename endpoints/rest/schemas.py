"""The JSON of the REST service: what is taken is checked here, what is given is described here."""

import json
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from storage.records import Role

Name = Annotated[str, Field(min_length=1, max_length=64)]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Pose = Annotated[
    list[Number],
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
        raise ValueError("parameters must be finite and not deeply nested") from error
    if length > MAX_PARAMETERS:
        raise ValueError(f"parameters may have {MAX_PARAMETERS} characters of JSON, not {length}")
    return value


class _Body(BaseModel):
    model_config = ConfigDict(extra="forbid")


class _Answer(BaseModel):
    model_config = ConfigDict(from_attributes=True)


class Problem(BaseModel):
    """What went wrong (RFC 9457)."""

    type: str = Field(examples=["urn:ppaas:problem:goal-occupied"])
    title: str
    status: int
    detail: str = Field(description="What is wrong, and what to do about it")
    code: int | None = Field(None, description="Of planning errors: that of Nav2's ComputePathToPose, 201–208")


# -- tokens and users --------------------------------------------------------------------------------------------------


class Credentials(_Body):
    """What to log in with."""

    user: str = Field(max_length=64)
    password: str = Field(max_length=1024)


class TokenAnswer(_Answer):
    """A login."""

    token: str
    expires: float = Field(description="Seconds since the epoch")


class NewUser(_Body):
    """A user to be made."""

    id: Name
    password: str = Field(min_length=8, max_length=1024)
    role: Role = "user"


class UserAnswer(_Answer):
    """A user."""

    id: str
    role: Role


# -- maps --------------------------------------------------------------------------------------------------------------


class MapSummary(_Answer):
    """A map, without what only its files tell."""

    id: str
    owner: str
    version: str = Field(description="SHA-256 of its files")
    readers: list[str] = Field(description="Who else may see it and plan on it; `*` is everybody")
    created: float = Field(description="Seconds since the epoch")


class MapAnswer(MapSummary):
    """A map."""

    resolution: float = Field(description="Edge of a cell [m]")
    width: int = Field(description="Cells along x")
    height: int = Field(description="Cells along y")
    origin: Triple


# -- robots ------------------------------------------------------------------------------------------------------------


class RobotFile(_Body):
    """The JSON file of a robot."""

    map: Name
    model: Name = "turtlebot2"
    initial_pose: Pose = [0.0, 0.0, 0.0]
    cores: Annotated[Number, Field(gt=0.0, le=MAX_CORES, description="Size of its container")] = 1.0
    base_global_planner: Name = "dijkstra"
    base_local_planner: Name = "dwa"
    parameters: Annotated[dict[str, Any], AfterValidator(_plain)] = {}


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


# -- machines and containers -------------------------------------------------------------------------------------------


class MachineAnswer(_Answer):
    """A machine."""

    id: str
    cores: int
    capacity: float = Field(description="Size it may give to containers, in cores")
    containers: int
    memory: int = Field(description="Bytes")
    memory_used: int = Field(description="Bytes")
    load: float = Field(description="CPU in use, in cores")


class MapVersionAnswer(_Answer):
    """One version of a map."""

    id: str
    version: str


class ContainerAnswer(_Answer):
    """A container."""

    id: str
    kind: Literal["robot", "planning"]
    user: str
    robot: str | None
    map: MapVersionAnswer
    machine: str
    cores: float
    state: Literal["starting", "ready"]
    pid: int | None
    pss: int | None = Field(description="Proportional set size [bytes]")
    ready_seconds: float | None = Field(description="From the order to start it until it answered [s]")


# -- plans -------------------------------------------------------------------------------------------------------------


class PlanFile(_Body):
    """A path that is asked for."""

    start: Pose
    goal: Pose
    planner: Name = "dijkstra"
    tolerance: Annotated[Number, Field(ge=0.0, description="How far off the goal will do, if it is blocked [m]")] = 0.0
    timeout: Annotated[Number, Field(gt=0.0)] | None = Field(None, description="Time allowed to the planner [s]")


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
    container: str
    pid: int


class PlanAnswer(_Path):
    """A path that was kept."""

    user: str
    robot: str | None
    start: Triple
    goal: Triple
    created: float = Field(description="Seconds since the epoch")
