"""Service that plans paths for programs: its request and its answer, from REST to a planner server and back.

REST decodes the body of a request into ``PathRequest``, and ``PathRequest`` goes to the container as it is. The planner
server writes ``PathAnswer`` from the planner's result; REST adds what it knows, and unpacks the poses once. The
pydantic schemas ``PlanFile`` and ``NewPlanAnswer`` describe the same fields for OpenAPI.
"""

from typing import Annotated, Any

from msgspec import Meta, Raw, field

from ppaas.messages.base.message import Message, OwnMessage, ServiceType
from ppaas.plans.stored import Origin

MAX_COORDINATE = 1e9
"""Largest x, y or yaw of a pose [m, rad]: beyond any map, and small enough for exact arithmetic."""

DEFAULT_TIMEOUT = 10.0
"""Time limit of a request that names none [s]."""

_Coordinate = Annotated[float, Meta(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]
RequestPose = Annotated[tuple[_Coordinate, ...], Meta(min_length=2, max_length=3)]
"""x, y [m] and, optionally, yaw [rad] (default 0) in the frame of the map."""

Timeout = Annotated[float, Meta(gt=0.0)]


class PathRequest(Message):
    """Request for a path. Field names, bounds and defaults are the same as in the JSON that REST accepts.

    REST checks the names of the planner and of labels; the master reads ``labels`` and ``queue``, a container does not.

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
    planner: str = "dijkstra"
    tolerance: Annotated[float, Meta(ge=0.0)] = 0.0
    timeout: Timeout = DEFAULT_TIMEOUT
    reuse: bool = True
    labels: dict[str, str] = field(default_factory=dict)
    queue: bool = False
    parameters: dict[str, Any] = field(default_factory=dict)


class PathAnswer(OwnMessage):
    """Path, and the container that planned it. Its fields are the same as in the REST response, but for packed poses.

    Parameters
    ----------
    poses : bytes
        Poses from start to goal in the frame of the map, packed (``ppaas.plans.encoding.codes``).
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
    container, pid, map, version
        Id and process id of the container, and the map version; empty in the answer of a planner server, which is the
        same in all containers.
    """

    poses: bytes
    cost: float
    length: float
    expanded: int
    seconds: float
    planner: str
    plan_id: str
    origin: Origin
    reused: str | None
    conditions: Raw
    container: str = ""
    pid: int = 0
    map: str = ""
    version: str = ""


ComputePackedPath = ServiceType("ppaas_msgs/ComputePackedPath", PathRequest, PathAnswer)
"""Not in the registry of ROS types: no client of a robot can call it, and ROS has no type for its dictionaries."""
