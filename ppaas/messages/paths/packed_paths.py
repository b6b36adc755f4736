"""Paths as bytes, between a planner server and the processes that answer programs."""

from ppaas.messages.base.message import OwnMessage, ServiceType

PACKAGE = "ppaas_msgs"


class ComputePackedPathRequest(OwnMessage):
    """``ppaas_msgs/ComputePackedPath`` request.

    Parameters
    ----------
    start, goal : list of 3 float
        x, y [m], yaw [rad] in the frame of the map.
    planner, tolerance, timeout, reuse, parameters
        As in the request of ``ppaas_msgs/ComputePath``.
    """

    start: list[float]
    goal: list[float]
    planner: str = ""
    tolerance: float = 0.0
    timeout: float = 5.0
    reuse: bool = True
    parameters: str = ""


class ComputePackedPathResponse(OwnMessage):
    """``ppaas_msgs/ComputePackedPath`` response.

    Parameters
    ----------
    poses : bytes
        Poses from start to goal in the frame of the map, packed (``ppaas.plans.encoding.packed_poses``).
    cost, length, expanded, seconds, planner, plan_id, origin, reused, conditions
        As in the response of ``ppaas_msgs/ComputePath``.
    """

    poses: bytes
    cost: float
    length: float
    expanded: int
    seconds: float
    planner: str
    plan_id: str = ""
    origin: str = "computed"
    reused: str = ""
    conditions: str = "{}"


ComputePackedPath = ServiceType("ppaas_msgs/ComputePackedPath", ComputePackedPathRequest, ComputePackedPathResponse)

SERVICES = (ComputePackedPath,)
