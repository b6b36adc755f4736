"""``nav_msgs``."""

from typing import ClassVar

from msgspec import Raw, field

from ppaas.messages.base.message import Empty, Float32, Int8, Message, ServiceType, UInt32
from ppaas.messages.base.std_msgs import FrameId, Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovariance, TwistWithCovariance


class MapMetaData(Message):
    """``nav_msgs/MapMetaData``: resolution [m/cell]; origin is the pose of the lower-left corner of cell (0, 0)."""

    ros_order: ClassVar[tuple[str, ...]] = ("map_load_time", "resolution", "width", "height", "origin")

    resolution: Float32
    width: UInt32
    height: UInt32
    origin: Pose
    map_load_time: Time = field(default_factory=Time)


class OccupancyGrid(Message):
    """``nav_msgs/OccupancyGrid``: row-major from the lower-left cell; 0 to 100, −1 unknown.

    ``data`` may be encoded JSON, so that a sender need not build a list of a million numbers.
    """

    header: Header
    info: MapMetaData
    data: list[Int8] | Raw


class Odometry(Message):
    """``nav_msgs/Odometry``: pose in ``header.frame_id``, twist in ``child_frame_id``."""

    header: Header
    child_frame_id: FrameId
    pose: PoseWithCovariance
    twist: TwistWithCovariance


class Path(Message):
    """``nav_msgs/Path``. ``poses`` may be encoded JSON, like the cells of a grid."""

    header: Header
    poses: list[PoseStamped] | Raw


class Goals(Message):
    """``nav_msgs/Goals``: poses to be reached or passed in order."""

    header: Header
    goals: list[PoseStamped]


class GetPlanRequest(Message):
    """``nav_msgs/GetPlan`` request; ``tolerance`` is the radius around the goal [m]."""

    start: PoseStamped
    goal: PoseStamped
    tolerance: Float32 = 0.0


class GetPlanResponse(Message):
    """``nav_msgs/GetPlan`` response; the path is empty if none was found."""

    plan: Path


class GetMapResponse(Message):
    """``nav_msgs/GetMap`` response."""

    map: OccupancyGrid = field()


GetPlan = ServiceType("nav_msgs/GetPlan", GetPlanRequest, GetPlanResponse)
GetMap = ServiceType("nav_msgs/GetMap", Empty, GetMapResponse)

SERVICES = (GetPlan, GetMap)
