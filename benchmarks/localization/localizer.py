"""Localization nodes of a clone, run alone: they get odometry and scans, and return poses."""

from typing import Any

from ppaas.clock import monotonic
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.amcl.node import GLOBAL_LOCALIZATION, AmclNode
from ppaas.nodes.base import Payload
from ppaas.nodes.frames import BASE_LINK
from ppaas.nodes.graph import Graph
from ppaas.nodes.tf.state_publisher import StatePublisherNode, StatePublisherParameters
from ppaas.parameters import read_parameters
from ppaas.robot_model.known_models import robot_model
from ppaas.transforms.planar import transform_message

MODEL = "turtlebot2"


class Localizer:
    """Nodes ``robot_state_publisher`` and ``amcl`` in their own graph.

    Parameters
    ----------
    layers : MapLayers
        Layers of the map.
    start : Pose2D
        Initial pose of the robot.
    parameters : dict
        Parameters of amcl by name.

    Attributes
    ----------
    seconds : list of float
        Time of each scan [s]: to move and weigh the particles, and to publish the pose.

    Raises
    ------
    InvalidParameter
        A parameter is unknown, or its value is invalid.
    """

    def __init__(self, layers: MapLayers, start: Pose2D, parameters: dict[str, Any]) -> None:
        self.seconds: list[float] = []
        self._told: list[Pose2D] = []
        self._now = 0.0
        self._graph = Graph(clock=self._clock, stamp_clock=self._clock)
        body = robot_model(MODEL)
        self._lasers: dict[Pose2D, str] = {}
        read = read_parameters(AmclParameters, AmclNode.name, parameters)
        self._graph.add(lambda context: StatePublisherNode(context, body, StatePublisherParameters()))
        self._graph.add(lambda context: AmclNode(context, layers, start, read))
        self._graph.tap("amcl_pose", self._on_pose)

    def _clock(self) -> float:
        return self._now

    def _on_pose(self, _: str, message: Any) -> None:
        assert isinstance(message, PoseWithCovarianceStamped)
        self._told.append(message.pose.pose.planar())

    def odometry(self, message: Odometry) -> None:
        """Process odometry."""
        self._now = message.header.stamp.seconds()
        self._graph.inject("odom", message)

    def scan(self, message: LaserScan) -> Pose2D | None:
        """Process a scan; return the estimated pose, or None if the scan waits for odometry of its time."""
        self._told.clear()
        began = monotonic()
        self._graph.inject("scan", message)
        if not self._told:
            return None
        self.seconds.append(monotonic() - began)
        return self._told[-1]

    def frame_of(self, laser: Pose2D) -> str:
        """Return the frame for scans of a laser with a pose in the robot's frame [m, rad]."""
        if laser not in self._lasers:
            self._lasers[laser] = frame = f"laser_{len(self._lasers)}"
            self._graph.inject("tf_static", TFMessage([transform_message(BASE_LINK, frame, laser, Time())]))
        return self._lasers[laser]

    def look_everywhere(self) -> None:
        """Call ``global_localization``.

        Raises
        ------
        InvalidMap
            No cell of the map is free.
        """
        self._graph.call(GLOBAL_LOCALIZATION.name, Empty(), _raise_error)


def _raise_error(answer: Payload | PPaaSError) -> None:
    if isinstance(answer, PPaaSError):
        raise answer
