"""``explore_msgs``: the action ``explore`` of this project, one type per topic as in ROS 1."""

from typing import ClassVar

from msgspec import field

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus
from ppaas.messages.base.message import Message, UInt32
from ppaas.messages.base.std_msgs import Duration, Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped


def _nowhere() -> PoseStamped:
    return PoseStamped(Header(), Pose.of(Pose2D(0.0, 0.0)))


class ExploreGoal(Message):
    """``explore_msgs/ExploreGoal``.

    Parameters
    ----------
    return_to_start : bool
        Whether the robot drives back to where it was when the goal came, once no frontier is left.
    """

    return_to_start: bool = False


class ExploreActionGoal(Message):
    """``explore_msgs/ExploreActionGoal``."""

    ros_order: ClassVar[tuple[str, ...]] = ("header", "goal_id", "goal")

    goal: ExploreGoal = field(default_factory=ExploreGoal)
    goal_id: GoalID = field(default_factory=GoalID)
    header: Header = field(default_factory=Header)


class ExploreFeedback(Message):
    """``explore_msgs/ExploreFeedback``.

    Parameters
    ----------
    target : PoseStamped
        The pose that the robot drives to; without a frame while it stands.
    frontiers : int
        Number of frontiers left.
    unreachable : int
        Number of places that the robot gave up.
    area : float
        Known area of the map [m²].
    distance : float
        Distance driven [m].
    exploration_time : Duration
        Time since the goal came.
    text : str
        What the robot does, or why it stands.
    """

    target: PoseStamped = field(default_factory=_nowhere)
    frontiers: UInt32 = 0
    unreachable: UInt32 = 0
    area: float = 0.0
    distance: float = 0.0
    exploration_time: Duration = field(default_factory=Duration)
    text: str = ""


class ExploreActionFeedback(Message):
    """``explore_msgs/ExploreActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: ExploreFeedback


class ExploreResult(Message):
    """``explore_msgs/ExploreResult``: the same numbers at the end.

    Parameters
    ----------
    frontiers : int
        Number of frontiers left; 0 if the goal succeeded.
    unreachable : int
        Number of places that the robot gave up.
    area : float
        Known area of the map [m²].
    distance : float
        Distance driven [m].
    exploration_time : Duration
        Time since the goal came.
    """

    frontiers: UInt32 = 0
    unreachable: UInt32 = 0
    area: float = 0.0
    distance: float = 0.0
    exploration_time: Duration = field(default_factory=Duration)


class ExploreActionResult(Message):
    """``explore_msgs/ExploreActionResult``."""

    header: Header
    status: GoalStatus
    result: ExploreResult
