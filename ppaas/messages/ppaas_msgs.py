"""``ppaas_msgs``: what ROS has no type for."""

from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.message import Message, ServiceType


class ComputePathRequest(Message):
    """``ppaas_msgs/ComputePath`` request.

    Parameters
    ----------
    start, goal : Pose
        In the frame of the map.
    planner : str
        Name or ROS alias of a global planner; empty for the one that the server was made with.
    tolerance : float
        If the goal is blocked, a free place within this distance will do [m].
    timeout : float
        Longest time to plan [s].
    reuse : bool
        Whether a plan that is kept will do where it comes sooner than one that is computed.
    """

    start: Pose
    goal: Pose
    planner: str = ""
    tolerance: float = 0.0
    timeout: float = 5.0
    reuse: bool = True


class ComputePathResponse(Message):
    """``ppaas_msgs/ComputePath`` response.

    Parameters
    ----------
    poses : str
        From start to goal, in the frame of the map: JSON, a list of rows [x, y, z [m], qx, qy, qz, qw]. It is text
        within the message, so that thousands of numbers are handed on as they were written.
    cost : float
        Sum of the weights of the moves.
    length : float
        Along the poses [m].
    expanded : int
        Cells that were settled.
    seconds : float
        Time it took.
    planner : str
        Who planned.
    plan_id : str
        By which the plan may be kept: of the same plan the same.
    origin : str
        Whether it was ``computed``, or a plan that is kept was ``reused``, or ``stitched`` to the ends.
    reused : str
        Id of that plan.
    conditions : str
        Under which it was made: JSON, the parameters of the planner and what else a plan is kept with.
    """

    poses: str
    cost: float
    length: float
    expanded: int
    seconds: float
    planner: str
    plan_id: str = ""
    origin: str = "computed"
    reused: str = ""
    conditions: str = "{}"


ComputePath = ServiceType("ppaas_msgs/ComputePath", ComputePathRequest, ComputePathResponse)


class ComputeCostsRequest(Message):
    """``ppaas_msgs/ComputeCosts`` request.

    Parameters
    ----------
    starts, goals : list of Pose
        In the frame of the map; headings do not count.
    timeout : float
        Longest time for all of it [s].
    """

    starts: list[Pose]
    goals: list[Pose]
    timeout: float = 5.0


class ComputeCostsResponse(Message):
    """``ppaas_msgs/ComputeCosts`` response.

    Parameters
    ----------
    costs : str
        What the cheapest path costs: JSON, a row for each start, a number in it for each goal, null where no way leads.
    seconds : float
        Time it took.
    """

    costs: str
    seconds: float


ComputeCosts = ServiceType("ppaas_msgs/ComputeCosts", ComputeCostsRequest, ComputeCostsResponse)

SERVICES = (ComputePath, ComputeCosts)
