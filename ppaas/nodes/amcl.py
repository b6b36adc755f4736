"""Localization as a node: tells where the odometry frame lies in the map."""

from dataclasses import dataclass
from typing import ClassVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.localization.beams import choose_beams, scan_points
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.particle_filter import ParticleFilter
from ppaas.maps.layers import MapLayers
from ppaas.messages.geometry_msgs import Pose, PoseArray, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.std_msgs import Header, Time
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.base import Context, Demands, Node, Payload, Topic
from ppaas.nodes.checks import expect, finite_pose
from ppaas.nodes.frames import BASE_LINK, MAP, ODOM, TF, TF_STATIC, FrameListener
from ppaas.transforms import tf_time, transform_message

SCAN_TOPIC = Topic("scan", LaserScan)
SCAN_RATE = 80e3
"""What a laser of 360 beams and 10 Hz says, as JSON [bytes/s]."""

LONGEST_GAP = 5.0
"""A robot whose odometry is farther than this from where it was at the checkpoint [m] has reset its odometry."""

_PLANAR = np.ix_((0, 1, 5), (0, 1, 5))
"""Where x, y and yaw stand in ROS's 6×6 covariance."""


@dataclass(frozen=True, slots=True)
class ParticleCloud:
    """The particles, by reference; they become ``geometry_msgs/PoseArray`` where they leave the home."""

    particles: NDArray[np.float64]
    stamp: float

    def to_message(self) -> PoseArray:
        """Return the message."""
        header = Header(stamp=Time.of(self.stamp), frame_id=MAP)
        return PoseArray(header, [Pose.of(Pose2D(*row)) for row in self.particles.tolist()])


class AmclState(msgspec.Struct):
    """What localization needs to go on elsewhere: where it was by the map and by odometry, and how sure."""

    pose: tuple[float, float, float]
    covariance: list[list[float]]
    odom: tuple[float, float, float] | None


class AmclNode(Node):
    """Takes scans, ``tf`` and ``initialpose``; gives ``tf`` map → odom, ``amcl_pose`` and ``particlecloud``.

    As amcl does, with one difference: map → odom and ``amcl_pose`` come with every scan, also when the robot has not
    moved far enough for the particles to be updated, so that others hear of a robot that stands.

    A scan waits until odometry has reached its stamp; a newer one takes its place. A stamp of zero means the latest
    odometry.

    Parameters
    ----------
    context : Context
        Of its home.
    layers : MapLayers
        The map.
    initial_pose : Pose2D
        In the map.
    parameters : AmclParameters
        With the names of amcl.
    """

    name: ClassVar[str] = "amcl"
    demands: ClassVar[Demands] = Demands(0.15, rates={SCAN_TOPIC.name: SCAN_RATE})
    subscribes: ClassVar[tuple[Topic, ...]] = (
        SCAN_TOPIC,
        TF,
        TF_STATIC,
        Topic("initialpose", PoseWithCovarianceStamped),
    )
    publishes: ClassVar[tuple[Topic, ...]] = (
        TF,
        Topic("amcl_pose", PoseWithCovarianceStamped),
        Topic("particlecloud", PoseArray),
    )

    def __init__(self, context: Context, layers: MapLayers, initial_pose: Pose2D, parameters: AmclParameters) -> None:
        super().__init__(context)
        self._parameters = parameters
        self._filter = ParticleFilter(layers, parameters)
        spread = (parameters.initial_cov_xx, parameters.initial_cov_yy, parameters.initial_cov_aa)
        self._filter.initialise(initial_pose, np.diag(spread))
        self._frames = FrameListener()
        self._waiting: LaserScan | None = None
        self._map_to_odom: Pose2D | None = None
        self._odom: Pose2D | None = None
        self._restored: AmclState | None = None

    def on_message(self, topic: str, message: Payload) -> None:
        """Take a scan, a transform or a pose to start anew from.

        Raises
        ------
        InvalidInput
            It is not finite, or has the wrong size.
        TransformError
            The frame of a scan or of an initial pose is not known, or its stamp lies too far back.
        """
        if topic == SCAN_TOPIC.name:
            self._on_scan(expect(message, LaserScan))
        elif topic == "initialpose":
            self._on_initial_pose(expect(message, PoseWithCovarianceStamped))
        else:
            self._frames.hear(topic, expect(message, TFMessage), self.context.now())
            self._process_waiting()

    # -- initial pose --------------------------------------------------------------------------------------------------

    def _on_initial_pose(self, message: PoseWithCovarianceStamped) -> None:
        if message.header.frame_id.lstrip("/") not in ("", MAP):
            raise TransformError(f"an initial pose is given in {MAP!r}, not in {message.header.frame_id!r}")
        pose = finite_pose(message.pose.pose, "an initial pose")
        if len(message.pose.covariance) != 36:
            raise InvalidInput(f"a covariance has 36 numbers, not {len(message.pose.covariance)}")
        covariance = np.array(message.pose.covariance).reshape(6, 6)[_PLANAR]
        self._filter.initialise(pose, covariance)
        self._restored = None

    # -- scans ---------------------------------------------------------------------------------------------------------

    def _on_scan(self, scan: LaserScan) -> None:
        self._laser(scan)
        self._waiting = scan
        self._process_waiting()

    def _laser(self, scan: LaserScan) -> Pose2D:
        frame = scan.header.frame_id.lstrip("/")
        return self._frames.tree.lookup(BASE_LINK, frame or BASE_LINK)

    def _process_waiting(self) -> None:
        scan, newest = self._waiting, self._frames.tree.newest(BASE_LINK)
        if scan is None or newest is None:
            return
        stamp = tf_time(scan.header.stamp) or newest
        if stamp > newest:
            return
        self._waiting = None
        odom = self._frames.tree.lookup(ODOM, BASE_LINK, stamp)
        self._go_on(odom)
        if self._filter.needs_update(odom):
            beams = choose_beams(scan_points(scan, self._laser(scan)), self._parameters.laser_max_beams)
            estimate = self._filter.update(odom, beams, scan.range_max)
            self._map_to_odom = estimate.pose @ odom.inverse()
            self.context.publish("particlecloud", ParticleCloud(self._filter.particles, stamp))
        self._odom = odom
        self._tell(stamp)

    def _tell(self, stamp: float) -> None:
        assert self._map_to_odom is not None and self._odom is not None
        good_until = Time.of(stamp + self._parameters.transform_tolerance)
        correction = transform_message(MAP, ODOM, self._map_to_odom, good_until)
        self.context.publish(TF.name, TFMessage([correction]))
        covariance = np.zeros((6, 6))
        covariance[_PLANAR] = self._filter.estimate.covariance
        pose = PoseWithCovariance(Pose.of(self._map_to_odom @ self._odom), covariance.ravel().tolist())
        header = Header(stamp=Time.of(stamp), frame_id=MAP)
        self.context.publish("amcl_pose", PoseWithCovarianceStamped(header, pose))

    # -- going on elsewhere --------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes:
        """Return where the robot is."""
        if self._restored is not None:
            return msgspec.json.encode(self._restored)
        estimate = self._filter.estimate
        pose = estimate.pose
        if self._map_to_odom is not None and self._odom is not None:
            pose = self._map_to_odom @ self._odom
        return msgspec.json.encode(AmclState((pose.x, pose.y, pose.theta), estimate.covariance.tolist(), self._odom))

    def restore(self, state: bytes) -> None:
        """Go on from there, and from how far odometry says the robot has come meanwhile."""
        self._restored = msgspec.json.decode(state, type=AmclState)
        self._filter.initialise(Pose2D(*self._restored.pose), np.array(self._restored.covariance))

    def _go_on(self, odom: Pose2D) -> None:
        """With the first odometry after a restore, move on by what was missed."""
        if self._restored is None:
            return
        state, self._restored = self._restored, None
        if state.odom is None or odom.distance_to(Pose2D(*state.odom)) > LONGEST_GAP:
            return
        missed = Pose2D(*state.odom).inverse() @ odom
        self._filter.initialise(Pose2D(*state.pose) @ missed, np.array(state.covariance))
