"""Requests of programs for paths and costs, and their results.

REST decodes the body of a request into one of these structures, and encodes the result, the poses of a path in one of
several forms. Its pydantic schemas describe the same fields for OpenAPI: ``PlanFile``, ``CostFile``, ``NewPlanAnswer``
and ``CostMatrixAnswer``. A container is called by the ROS services ``ppaas_msgs/ComputePackedPath`` and
``ComputeCosts``.
"""

from typing import Annotated, Any

import msgspec
from msgspec import Meta, Raw

from engine.specs.machine_settings import MOST_LABELS
from ppaas.geometry import Poses
from ppaas.plans.stored import Origin
from storage.names import PATTERN

MAX_COORDINATE = 1e9
"""Largest x, y or yaw of a pose [m, rad]: beyond any map, and small enough for exact arithmetic."""

DEFAULT_TIMEOUT = 10.0
"""Time limit of a request that names none [s]."""

_Coordinate = Annotated[float, Meta(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]
RequestPose = Annotated[tuple[_Coordinate, ...], Meta(min_length=2, max_length=3)]
"""x, y [m] and, optionally, yaw [rad] (default 0) in the frame of the map."""

_Name = Annotated[str, Meta(pattern=rf"^{PATTERN}\Z")]
_PluginName = Annotated[str, Meta(pattern=rf"^{PATTERN}((/|::){PATTERN})?\Z")]
RequestLabels = Annotated[dict[_Name, _Name], Meta(max_length=MOST_LABELS)]
Timeout = Annotated[float, Meta(gt=0.0)]


class PathRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Request for a path. Field names, bounds and defaults are the same as in the JSON that REST accepts.

    Parameters
    ----------
    start, goal : tuple of 2 or 3 float
        x, y [m] and, optionally, yaw [rad] in the frame of the map.
    planner : str
        Name of the planner, or its ROS name, such as ``navfn/NavfnROS``.
    tolerance : float
        If the goal is blocked, plan to the nearest free cell within this distance [m].
    timeout : float
        Time limit of the planner [s].
    reuse : bool
        Whether a stored plan may be returned if it is available sooner than a computed one.
    labels : dict of str to str
        Labels that the machine of the container must have.
    queue : bool
        Whether the request may wait for its turn if no container is available now.
    parameters : dict
        Parameters of the planner and the global costmap that differ from the usual ones, by name.
    """

    start: RequestPose
    goal: RequestPose
    planner: _PluginName = "dijkstra"
    tolerance: Annotated[float, Meta(ge=0.0)] = 0.0
    timeout: Timeout = DEFAULT_TIMEOUT
    reuse: bool = True
    labels: RequestLabels = {}
    queue: bool = False
    parameters: dict[str, Any] = {}


class PathAnswer(msgspec.Struct, frozen=True):
    """Path, and the container that planned it. Its fields are the same as in the REST response.

    Parameters
    ----------
    poses : (n, 7) float64 array
        Rows x, y, z [m], qx, qy, qz, qw in the frame of the map.
    cost : float
        Sum of the weights of the moves.
    length : float
        Length along the poses [m].
    expanded : int
        Number of cells whose value was settled.
    seconds : float
        Planning time [s].
    planner : str
        Name of the planner.
    plan_id : str
        Id under which the plan may be stored; equal plans have equal ids.
    origin : str
        ``computed``, ``reused`` or ``stitched``.
    reused : str, optional
        Id of the stored plan that it was made from; None if it was computed.
    conditions : Raw
        JSON object: the conditions of the plan, such as the planner's parameters.
    container : str
        Id of the container that planned it.
    pid : int
        Process id of this container.
    map, version : str
        Map version that it was planned on.
    """

    poses: Poses
    cost: float
    length: float
    expanded: int
    seconds: float
    planner: str
    plan_id: str
    origin: Origin
    reused: str | None
    conditions: Raw
    container: str
    pid: int
    map: str
    version: str


class CostRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Request for the costs of the cheapest paths from each start to each goal.

    Parameters
    ----------
    starts, goals : tuple of poses
        Each x, y [m] and, optionally, yaw [rad] in the frame of the map.
    timeout : float
        Time limit of the whole request [s].
    labels : dict of str to str
        Labels that the machine of the container must have.
    parameters : dict
        ``allow_unknown`` and parameters of the global costmap that differ from the usual ones, by name.
    """

    starts: tuple[RequestPose, ...]
    goals: tuple[RequestPose, ...]
    timeout: Timeout = DEFAULT_TIMEOUT
    labels: RequestLabels = {}
    parameters: dict[str, Any] = {}


class CostAnswer(msgspec.Struct, frozen=True):
    """Costs, and the container that computed them. Encoded as JSON, it is the response of REST.

    Parameters
    ----------
    costs : Raw
        JSON: a row for each start with a number for each goal, null if there is no path, as the container wrote it.
    seconds : float
        Computing time [s].
    container : str
        Id of the container that computed them.
    pid : int
        Process id of this container.
    map, version : str
        Map version that they were computed on.
    """

    costs: Raw
    seconds: float
    container: str
    pid: int
    map: str
    version: str
