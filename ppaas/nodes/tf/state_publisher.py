"""Node ``robot_state_publisher``: publishes the robot's frames, from its odometry and its model."""

from typing import ClassVar

from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.base import Context, Node, Payload, Topic
from ppaas.nodes.frames import ODOM as ODOM_FRAME
from ppaas.nodes.frames import FrameNames, is_scan_odometry, prefixed
from ppaas.nodes.message_checks import expect, finite_pose
from ppaas.nodes.tf.body_frames import BodyFrames
from ppaas.nodes.tf.robot_transforms import RobotTransforms
from ppaas.nodes.tf.urdf_text import UrdfText
from ppaas.nodes.topics import ODOM, ROBOT_DESCRIPTION, TF, TF_STATIC
from ppaas.parameters import Parameters
from ppaas.robot_model.known_models import RobotModel
from ppaas.transforms.planar import transform_message


class StatePublisherParameters(Parameters, frozen=True):
    """Parameters of the state publisher.

    Parameters
    ----------
    laser_frame : str
        Frame of the robot's scans; empty for its model's frame.
    """

    laser_frame: str = ""


class StatePublisherNode(Node):
    """Publishes the frame of each odometry message on ``tf``, and the frames of the robot's body on ``tf_static``.

    It replaces ROS's robot_state_publisher and the transform broadcaster of the base driver, so that a small robot only
    has to send its odometry. A stamp of zero means now. A robot that publishes the transform of its odometry itself is
    believed: then its odometry messages only give its velocity, as in ROS.

    Odometry without frames moves the robot's body in its odometry frame. Whatever its frames are called, they are
    joined with the frame in which the robot is driven (`ppaas.nodes.tf.body_frames`).

    Parameters
    ----------
    context : Context
        The node's context.
    model : RobotModel
        Model of the robot.
    parameters : StatePublisherParameters
    names : FrameNames, optional
        Names of the robot's frames.
    urdf : UrdfText, optional
        URDF of the robot, to be published on ``robot_description``.
    """

    name: ClassVar[str] = "robot_state_publisher"
    subscribes: ClassVar[tuple[Topic, ...]] = (ODOM, TF, TF_STATIC)
    publishes: ClassVar[tuple[Topic, ...]] = (TF, TF_STATIC, ROBOT_DESCRIPTION)

    def __init__(
        self,
        context: Context,
        model: RobotModel,
        parameters: StatePublisherParameters,
        names: FrameNames | None = None,
        urdf: UrdfText | None = None,
    ) -> None:
        super().__init__(context)
        self._names = names or FrameNames()
        self._body = BodyFrames(model, parameters.laser_frame, self._names)
        self._robot = RobotTransforms()
        self._own: list[TFMessage] = []
        self._urdf = urdf

    def start(self) -> None:
        """Publish the static transforms of the robot's body, and its URDF."""
        if self._urdf is not None:
            self.context.publish(ROBOT_DESCRIPTION.name, self._urdf)
        self._publish_static(self._body.at_start())

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle odometry or transforms.

        Raises
        ------
        InvalidInput
            A number is not finite, or the orientation is all zero.
        TransformError
            The odometry belongs to a sensor, and nothing says where on the robot it is.
        """
        if topic == ODOM.name:
            self._on_odometry(expect(message, Odometry))
            return
        transforms = expect(message, TFMessage)
        if is_scan_odometry(transforms):
            return  # it ends with the first odometry of the robot, which is published below
        if any(transforms is own for own in self._own):
            self._own = [own for own in self._own if own is not transforms]
            return
        self._body.hear(transforms.transforms, static=topic == TF_STATIC.name)
        if topic == TF_STATIC.name:
            self._robot.note_static(transforms.transforms)
        else:
            self._robot.note_moving(transforms.transforms, self.context.elapsed())
            self._publish_static(self._body.joints_of_transforms(transforms.transforms))

    def _on_odometry(self, odometry: Odometry) -> None:
        pose = finite_pose(odometry.pose.pose, "odometry")
        parent = odometry.header.frame_id.lstrip("/") or self._names.odom or prefixed(self._names.prefix, ODOM_FRAME)
        child = odometry.child_frame_id.lstrip("/") or self._names.base
        if not self._robot.moves(child, self.context.elapsed()):
            self._publish_odometry(parent, child, pose, odometry.header.stamp)
        self._publish_static(self._body.joints_of_odometry(child, self.context.elapsed()))

    def _publish_odometry(self, parent: str, child: str, pose: Pose2D, stamp: Time) -> None:
        moment = Time.of(self.context.now()) if stamp == Time() else stamp
        self._publish(TF, TFMessage([transform_message(parent, child, pose, moment)]))

    def _publish_static(self, transforms: list[TransformStamped]) -> None:
        if transforms:
            stamp = Time.of(self.context.now())
            for each in transforms:
                each.header.stamp = stamp
            self._publish(TF_STATIC, TFMessage(transforms))

    def _publish(self, topic: Topic, message: TFMessage) -> None:
        self._body.hear(message.transforms, static=topic is TF_STATIC)
        self._own.append(message)
        self.context.publish(topic.name, message)

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes | None:
        """Return the static transforms that the robot has sent as JSON, which it does only once; None without any."""
        return self._robot.state()

    def restore(self, state: bytes) -> None:
        """Publish the static transforms of a checkpoint again."""
        self._publish_static(self._robot.restore(state))
