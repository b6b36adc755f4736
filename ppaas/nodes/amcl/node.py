"""Localization as a node: tells where the odometry frame lies in the map."""

import logging
from typing import ClassVar

import msgspec
import numpy as np

from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.localization.beams import check_count
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.particle_filter import ParticleFilter
from ppaas.localization.pose_search import Found
from ppaas.localization.scan_plausibility import check_sight
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.messages.message import Empty, Message
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.std_msgs import Time
from ppaas.messages.std_srvs import EmptyService
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.nodes.amcl.continuity import LONGEST_GAP, Continuity
from ppaas.nodes.amcl.messages import ParticleCloud, pose_message, read_initial_pose
from ppaas.nodes.base import Context, Demands, Node, Payload, Reply, Service, Topic
from ppaas.nodes.frames import BASE_LINK, MAP, ODOM, FrameListener
from ppaas.nodes.message_checks import expect
from ppaas.thread_budget import Threads, one_thread
from ppaas.transforms.planar import tf_time, transform_message

logger = logging.getLogger(__name__)

GLOBAL_LOCALIZATION = Service("global_localization", EmptyService)
NOMOTION_UPDATE = Service("request_nomotion_update", EmptyService)


class AmclState(msgspec.Struct):
    """What localization needs to go on elsewhere: where it was by the map and by odometry, and how sure."""

    pose: tuple[float, float, float]
    covariance: list[list[float]]
    odom: tuple[float, float, float] | None
    searching: bool = False


class AmclNode(Node):
    """Takes scans, ``tf`` and ``initialpose``; gives ``tf`` map → odom, ``amcl_pose`` and ``particlecloud``.

    As amcl does, with one difference: map → odom and ``amcl_pose`` come with every scan, also when the robot has not
    moved far enough for the particles to be updated, so that others hear of a robot that stands.

    A scan waits until odometry has reached its stamp; a newer one takes its place. A stamp of zero means the latest
    odometry. A base that begins anew is taken to stand where it was.

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
    threads : callable
        Returns the most threads that kernels may use now.
    """

    name: ClassVar[str] = "amcl"
    demands: ClassVar[Demands] = Demands(0.15, rates={topics.SCAN.name: topics.SCAN_RATE})
    subscribes: ClassVar[tuple[Topic, ...]] = (topics.SCAN, topics.TF, topics.TF_STATIC, topics.INITIAL_POSE)
    publishes: ClassVar[tuple[Topic, ...]] = (topics.TF, topics.AMCL_POSE, topics.PARTICLE_CLOUD)
    services: ClassVar[tuple[Service, ...]] = (GLOBAL_LOCALIZATION, NOMOTION_UPDATE)

    def __init__(
        self,
        context: Context,
        layers: MapLayers,
        initial_pose: Pose2D,
        parameters: AmclParameters,
        threads: Threads = one_thread,
    ) -> None:
        super().__init__(context)
        self._parameters = parameters
        self._info, self._layers = layers.grid.info, layers
        self._filter = ParticleFilter(layers, parameters, threads)
        spread = (parameters.initial_cov_xx, parameters.initial_cov_yy, parameters.initial_cov_aa)
        self._filter.initialise(initial_pose, np.diag(spread))
        self._frames = FrameListener()
        self._waiting: LaserScan | None = None
        self._map_to_odom: Pose2D | None = None
        self._continuity = Continuity()
        self._restored: AmclState | None = None
        self._update_asked = False
        self._looking = False

    def on_message(self, topic: str, message: Payload) -> None:
        """Take a scan, a transform or a pose to start anew from.

        Raises
        ------
        InvalidInput
            It is not finite, has the wrong size, lies outside of the map, or is older than the one before.
        TransformError
            The frame of a scan or of an initial pose is not known, or its stamp lies too far back.
        """
        if topic == topics.SCAN.name:
            self._on_scan(expect(message, LaserScan))
        elif topic == topics.INITIAL_POSE.name:
            self._filter.initialise(*read_initial_pose(expect(message, PoseWithCovarianceStamped), self._info))
            self._restored = None
        else:
            self._frames.hear(topic, expect(message, TFMessage), self.context.now())
            self._process_waiting()

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Look for the robot all over the map, or update with the next scan though the robot has not moved.

        Raises
        ------
        InvalidMap
            The map has no free cell that the robot could be in.
        """
        if service == GLOBAL_LOCALIZATION.name:
            self._filter.initialise_globally()
            self._restored = None
        else:
            self._update_asked = True
        reply(Empty())

    # -- scans ---------------------------------------------------------------------------------------------------------

    def _on_scan(self, scan: LaserScan) -> None:
        laser, newest = self._laser(scan), self._frames.tree.newest(BASE_LINK)
        check_count(scan)
        check_sight(scan, self._layers, lambda: self._in_map(laser))
        stamp = tf_time(scan.header.stamp)
        if stamp:
            self._continuity.check_stamp(stamp, newest)
        self._waiting = scan
        self._process_waiting()

    def _laser(self, scan: LaserScan) -> Pose2D:
        frame = scan.header.frame_id.lstrip("/")
        return self._frames.tree.lookup(BASE_LINK, frame or BASE_LINK)

    def _in_map(self, laser: Pose2D) -> Pose2D | None:
        """Return where a laser is taken to be, if the robot was localized."""
        if self._map_to_odom is None:
            return None
        return self._map_to_odom @ self._frames.tree.lookup(ODOM, BASE_LINK) @ laser

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
        before = self._continuity.note(odom, stamp)
        if before is not None:
            self._begin_odometry_anew(before, odom)
        if self._update_asked or self._filter.needs_update(odom):
            self._update(scan, odom, stamp)
        # As ROS, so that whoever waits for the pose of a scan finds it by its stamp, to the nanosecond.
        self._tell(odom, stamp, scan.header.stamp if tf_time(scan.header.stamp) else Time.of(stamp))

    def _begin_odometry_anew(self, before: Pose2D, odom: Pose2D) -> None:
        jump = before @ odom.inverse()
        self._filter.rebase(jump)
        if self._map_to_odom is not None:
            self._map_to_odom = self._map_to_odom @ jump

    def _update(self, scan: LaserScan, odom: Pose2D, stamp: float) -> None:
        self._update_asked = False
        sensor = self._filter.sensor
        estimate = self._filter.update(odom, sensor.beams(scan, self._laser(scan)), sensor.range_max(scan))
        self._map_to_odom = estimate.pose @ odom.inverse()
        self.context.publish(topics.PARTICLE_CLOUD.name, ParticleCloud(self._filter.particles, stamp))
        self._look()

    def _look(self) -> None:
        """Have a lost robot looked for all over the map, in a job: that takes longer than a cycle of control."""
        search = None if self._looking else self._filter.next_search()
        if search is not None:
            self._looking = True
            self.context.start(search.run, self._on_found)

    def _on_found(self, found: Found | PPaaSError | None) -> None:
        self._looking = False
        if isinstance(found, PPaaSError):
            logger.warning("a robot that is lost cannot be looked for: %s", found)
        elif found is not None and self._filter.adopt(found):
            self._update_asked = True
        self._look()

    def _tell(self, odom: Pose2D, stamp: float, moment: Time) -> None:
        assert self._map_to_odom is not None
        if self._parameters.tf_broadcast:
            good_until = Time.of(stamp + self._parameters.transform_tolerance)
            correction = transform_message(MAP, ODOM, self._map_to_odom, good_until)
            self.context.publish(topics.TF.name, TFMessage([correction]))
        covariance = self._filter.estimate.covariance
        self.context.publish(topics.AMCL_POSE.name, pose_message(self._map_to_odom @ odom, covariance, moment))

    # -- going on elsewhere --------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes:
        """Return where the robot is."""
        if self._restored is not None:
            return msgspec.json.encode(self._restored)
        estimate, odom = self._filter.estimate, self._continuity.odom
        pose = estimate.pose
        if self._map_to_odom is not None and odom is not None:
            pose = self._map_to_odom @ odom
        state = AmclState((pose.x, pose.y, pose.theta), estimate.covariance.tolist(), odom, self._filter.searching)
        return msgspec.json.encode(state)

    def restore(self, state: bytes) -> None:
        """Go on from there, and from how far odometry says the robot has come meanwhile."""
        self._restored = msgspec.json.decode(state, type=AmclState)
        self._filter.initialise(Pose2D(*self._restored.pose), np.array(self._restored.covariance))

    def _go_on(self, odom: Pose2D) -> None:
        """With the first odometry after a restore, move on by what was missed, or go on to look for the robot."""
        if self._restored is None:
            return
        state, self._restored = self._restored, None
        if state.searching:
            self._filter.initialise_globally()
        elif state.odom is not None and odom.distance_to(Pose2D(*state.odom)) <= LONGEST_GAP:
            missed = Pose2D(*state.odom).inverse() @ odom
            self._filter.initialise(Pose2D(*state.pose) @ missed, np.array(state.covariance))
