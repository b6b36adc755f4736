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
    """

    start: Pose
    goal: Pose
    planner: str = ""
    tolerance: float = 0.0
    timeout: float = 5.0


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
    """

    poses: str
    cost: float
    length: float
    expanded: int
    seconds: float
    planner: str


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
