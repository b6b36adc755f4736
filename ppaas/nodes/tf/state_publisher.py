"""Node ``robot_state_publisher``: publishes the robot's frames on ``tf``, from its odometry and its model."""

from typing import ClassVar

from ppaas.errors import InvalidInput
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.std_msgs import Time
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.base import Context, Node, Payload, Topic
from ppaas.nodes.frames import BASE_LINK
from ppaas.nodes.message_checks import expect, finite_pose
from ppaas.nodes.topics import ODOM, TF, TF_STATIC
from ppaas.parameters import Parameters
from ppaas.robot_model.known_models import RobotModel
from ppaas.transforms.planar import transform_message


class StatePublisherParameters(Parameters, frozen=True):
    """Parameters of the state publisher.

    Parameters
    ----------
    laser_frame : str
        Frame of the robot's scans; empty for that of its model.
    """

    laser_frame: str = ""


class StatePublisherNode(Node):
    """Publishes odom → base_link for each odometry message, and the pose of the laser on the base once.

    It replaces ROS's robot_state_publisher and the transform broadcaster of the base driver, so that a small robot only
    has to send its odometry. A stamp of zero means now.

    Parameters
    ----------
    context : Context
        The node's context.
    model : RobotModel
        Model of the robot.
    parameters : StatePublisherParameters
    """

    name: ClassVar[str] = "robot_state_publisher"
    subscribes: ClassVar[tuple[Topic, ...]] = (ODOM,)
    publishes: ClassVar[tuple[Topic, ...]] = (TF, TF_STATIC)

    def __init__(self, context: Context, model: RobotModel, parameters: StatePublisherParameters) -> None:
        super().__init__(context)
        self._laser = model.laser
        self._laser_frame = parameters.laser_frame or model.laser_frame

    def start(self) -> None:
        """Publish the static transform of the laser."""
        laser = transform_message(BASE_LINK, self._laser_frame, self._laser, Time.of(self.context.now()))
        self.context.publish(TF_STATIC.name, TFMessage([laser]))

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle odometry.

        Raises
        ------
        InvalidInput
            A number is not finite, or a frame is missing.
        """
        odometry = expect(message, Odometry)
        pose = finite_pose(odometry.pose.pose, "odometry")
        parent, child = odometry.header.frame_id.lstrip("/"), odometry.child_frame_id.lstrip("/")
        if not parent or not child:
            raise InvalidInput("odometry needs header.frame_id and child_frame_id, for example 'odom' and 'base_link'")
        stamp = odometry.header.stamp
        if stamp == Time():
            stamp = Time.of(self.context.now())
        self.context.publish(TF.name, TFMessage([transform_message(parent, child, pose, stamp)]))
