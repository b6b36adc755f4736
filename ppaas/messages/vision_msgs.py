"""``vision_msgs``: objects that a detector has found, in the fields of ROS 2."""

from msgspec import field

from ppaas.geometry import Pose2D
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Vector3


class ObjectHypothesis(Message):
    """``vision_msgs/ObjectHypothesis``: a class, such as ``person``, and its score from 0 to 1."""

    class_id: str
    score: float


class ObjectHypothesisWithPose(Message):
    """``vision_msgs/ObjectHypothesisWithPose``."""

    hypothesis: ObjectHypothesis
    pose: PoseWithCovariance


class BoundingBox3D(Message):
    """``vision_msgs/BoundingBox3D``: centre and size [m]."""

    center: Pose
    size: Vector3


class Detection3D(Message):
    """``vision_msgs/Detection3D``: an object; ``id`` is kept by a detector that tracks."""

    header: Header
    results: list[ObjectHypothesisWithPose] = field(default_factory=list)
    bbox: BoundingBox3D = field(default_factory=lambda: BoundingBox3D(Pose.of(Pose2D(0.0, 0.0)), Vector3()))
    id: str = ""


class Detection3DArray(Message):
    """``vision_msgs/Detection3DArray``."""

    header: Header
    detections: list[Detection3D] = field(default_factory=list)
