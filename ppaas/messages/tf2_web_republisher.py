"""``tf2_web_republisher``: transforms of selected frames at a low rate, for web clients."""

from typing import ClassVar

from msgspec import field

from ppaas.messages.actionlib_msgs import GoalID, GoalStatus
from ppaas.messages.base.message import Empty, Float32, Message, ServiceType
from ppaas.messages.base.std_msgs import Duration, Header
from ppaas.messages.geometry_msgs import TransformStamped


class TFArray(Message):
    """``tf2_web_republisher/TFArray``."""

    transforms: list[TransformStamped]


class TFSubscriptionGoal(Message):
    """``tf2_web_republisher/TFSubscriptionGoal``: send the poses of source frames in a target frame.

    Parameters
    ----------
    source_frames : list of str
        Frames whose poses are sent.
    target_frame : str
        Frame in which the poses are given.
    angular_thres, trans_thres : float
        A frame is sent when it has turned or moved by more than this [rad, m]; 0 sends it always.
    rate : float
        Rate at which the thresholds are checked [Hz].
    """

    source_frames: list[str]
    target_frame: str
    angular_thres: Float32 = 0.0
    trans_thres: Float32 = 0.0
    rate: Float32 = 10.0


class TFSubscriptionActionGoal(Message):
    """``tf2_web_republisher/TFSubscriptionActionGoal``."""

    ros_order: ClassVar[tuple[str, ...]] = ("header", "goal_id", "goal")

    goal: TFSubscriptionGoal
    goal_id: GoalID = field(default_factory=GoalID)
    header: Header = field(default_factory=Header)


class TFSubscriptionFeedback(Message):
    """``tf2_web_republisher/TFSubscriptionFeedback``."""

    transforms: list[TransformStamped]


class TFSubscriptionActionFeedback(Message):
    """``tf2_web_republisher/TFSubscriptionActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: TFSubscriptionFeedback


class TFSubscriptionActionResult(Message):
    """``tf2_web_republisher/TFSubscriptionActionResult``; the result itself is empty, as in ROS."""

    header: Header
    status: GoalStatus
    result: Empty = field(default_factory=Empty)


class RepublishTFsRequest(TFSubscriptionGoal):
    """``tf2_web_republisher/RepublishTFs`` request: a goal, and how long its topic lasts without a subscriber."""

    timeout: Duration = field(default_factory=Duration)


class RepublishTFsResponse(Message):
    """``tf2_web_republisher/RepublishTFs`` response."""

    topic_name: str


RepublishTFs = ServiceType("tf2_web_republisher/RepublishTFs", RepublishTFsRequest, RepublishTFsResponse)

SERVICES = (RepublishTFs,)
