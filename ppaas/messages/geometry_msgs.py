"""``geometry_msgs``.

A field that a message needs has no default: a client that omits it gets an error.
"""

from msgspec import field

from ppaas import geometry
from ppaas.geometry import quaternion_of, yaw_of
from ppaas.messages.base.message import Covariance, Float32, Message
from ppaas.messages.base.std_msgs import FrameId, Header


class Point(Message):
    """``geometry_msgs/Point`` [m]."""

    x: float
    y: float
    z: float = 0.0


class Point32(Message):
    """``geometry_msgs/Point32`` [m]."""

    x: Float32
    y: Float32
    z: Float32 = 0.0


class Vector3(Message):
    """``geometry_msgs/Vector3``."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


class Pose2D(Message):
    """``geometry_msgs/Pose2D`` [m, m, rad]."""

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0


class Quaternion(Message, kw_only=True):
    """``geometry_msgs/Quaternion``."""

    x: float = 0.0
    y: float = 0.0
    z: float
    w: float


class Pose(Message):
    """``geometry_msgs/Pose``."""

    position: Point
    orientation: Quaternion

    @classmethod
    def of(cls, pose: geometry.Pose2D) -> "Pose":
        """Return the pose in space of a pose in the plane, with z = 0."""
        x, y, z, w = quaternion_of(pose.theta)
        return cls(Point(pose.x, pose.y), Quaternion(x=x, y=y, z=z, w=w))

    def planar(self) -> geometry.Pose2D:
        """Return the pose in the plane: x, y and yaw."""
        q = self.orientation
        return geometry.Pose2D(self.position.x, self.position.y, yaw_of(q.x, q.y, q.z, q.w))


class PoseStamped(Message):
    """``geometry_msgs/PoseStamped``."""

    header: Header
    pose: Pose


class PoseArray(Message):
    """``geometry_msgs/PoseArray``."""

    header: Header
    poses: list[Pose]


class PoseWithCovariance(Message):
    """``geometry_msgs/PoseWithCovariance``: row-major 6×6 covariance of x, y, z, roll, pitch, yaw."""

    pose: Pose
    covariance: Covariance = field(default_factory=lambda: [0.0] * 36)


class PoseWithCovarianceStamped(Message):
    """``geometry_msgs/PoseWithCovarianceStamped``."""

    header: Header
    pose: PoseWithCovariance


class Polygon(Message):
    """``geometry_msgs/Polygon``: corners in order; the first is not repeated."""

    points: list[Point32]


class PolygonStamped(Message):
    """``geometry_msgs/PolygonStamped``."""

    header: Header
    polygon: Polygon


class Twist(Message):
    """``geometry_msgs/Twist`` [m/s, rad/s]."""

    linear: Vector3 = field(default_factory=Vector3)
    angular: Vector3 = field(default_factory=Vector3)


class TwistStamped(Message):
    """``geometry_msgs/TwistStamped``: a velocity in the frame ``header.frame_id``."""

    header: Header
    twist: Twist


class TwistWithCovariance(Message):
    """``geometry_msgs/TwistWithCovariance``."""

    twist: Twist
    covariance: Covariance = field(default_factory=lambda: [0.0] * 36)


class Transform(Message):
    """``geometry_msgs/Transform``."""

    translation: Vector3
    rotation: Quaternion


class TransformStamped(Message):
    """``geometry_msgs/TransformStamped``: the pose of ``child_frame_id`` in ``header.frame_id``."""

    header: Header
    child_frame_id: FrameId
    transform: Transform
