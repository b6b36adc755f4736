"""Node ``amcl``: publishes the transform from the map frame to the odometry frame."""

import logging
from typing import ClassVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.decoding import from_json
from ppaas.errors import Conflict, PPaaSError, Unavailable
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.particle_filter import ParticleFilter
from ppaas.localization.pose_search import PoseCandidates
from ppaas.localization.pose_tracker import POINTS, PoseTracker
from ppaas.localization.scan_match import check_plausible
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.base.std_msgs import String, Time
from ppaas.messages.fleet.floors import FindFloorRequest
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.messages.sensor_msgs import FluidPressure, LaserScan
from ppaas.messages.std_srvs import EmptyService
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.nodes.amcl.continuity import Continuity, has_driven
from ppaas.nodes.amcl.floor_service import FIND_FLOOR, FloorService
from ppaas.nodes.amcl.messages import ParticleCloud, pose_message, read_initial_pose
from ppaas.nodes.base import Context, Demands, Node, Payload, Reply, Service, Topic
from ppaas.nodes.frames import MAP, FrameListener, FrameNames
from ppaas.nodes.message_checks import expect
from ppaas.nodes.robot_scans import RobotScan, ScanReader, WaitingScans
from ppaas.nodes.scan_silence import SILENT, ScanSilence
from ppaas.thread_budget import Threads, one_thread
from ppaas.transforms.planar import transform_message

logger = logging.getLogger(__name__)

GLOBAL_LOCALIZATION = Service("global_localization", EmptyService)
NOMOTION_UPDATE = Service("request_nomotion_update", EmptyService)


class AmclState(msgspec.Struct):
    """Checkpoint of localization: pose in the map, its covariance, and odometry with the stamp of its scan [s]."""

    pose: tuple[float, float, float]
    covariance: list[list[float]]
    odom: tuple[float, float, float] | None
    searching: bool = False
    stamp: float | None = None


class AmclNode(Node):
    """Subscribes to scans, ``tf`` and ``initialpose``; publishes ``tf`` map → odom, ``amcl_pose``, ``particlecloud``.

    A robot that rides in lifts may publish ``barometer``; the service ``find_floor`` says on which floor it left.

    It behaves as amcl, with one difference: map → odom and ``amcl_pose`` are published for every scan, even if the
    robot has not moved far enough for an update of the particles. So other robots know of a robot that stands still.

    Scans wait until odometry has reached their stamps. A stamp of zero means the latest odometry. If the odometry is
    reset, the robot is assumed not to have moved; if it starts over after a silence, the robot has restarted, maybe
    elsewhere, and is searched on the whole map. While no scan can be used, or none comes, ``amcl/status`` gives
    the reason.

    Parameters
    ----------
    context : Context
        The node's context.
    layers : MapLayers
        The map.
    initial_pose : Pose2D
        In the map frame.
    parameters : AmclParameters
        Named as in amcl.
    threads : callable
        Returns the largest number of threads that kernels may use now.
    names : FrameNames, optional
        Names of the robot's frames.
    """

    name: ClassVar[str] = "amcl"
    demands: ClassVar[Demands] = Demands(0.15, rates={topics.SCAN.name: topics.SCAN_RATE})
    subscribes: ClassVar[tuple[Topic, ...]] = (
        topics.SCAN, topics.TF, topics.TF_STATIC, topics.INITIAL_POSE, topics.BAROMETER,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (
        topics.TF, topics.AMCL_POSE, topics.PARTICLE_CLOUD, topics.AMCL_STATUS,
    )  # fmt: skip
    services: ClassVar[tuple[Service, ...]] = (GLOBAL_LOCALIZATION, NOMOTION_UPDATE, FIND_FLOOR)

    def __init__(
        self,
        context: Context,
        layers: MapLayers,
        initial_pose: Pose2D,
        parameters: AmclParameters,
        threads: Threads = one_thread,
        *,
        names: FrameNames | None = None,
    ) -> None:
        super().__init__(context)
        self._parameters = parameters
        self._info, self._layers = layers.grid.info, layers
        self._filter = ParticleFilter(layers, parameters, threads)
        spread = (parameters.initial_cov_xx, parameters.initial_cov_yy, parameters.initial_cov_aa)
        self._filter.initialise(initial_pose, np.diag(spread))
        self._tracker = PoseTracker(layers, parameters)
        self._frames = FrameListener(names)
        self._scans = ScanReader(self._frames, warns=True)
        self._waiting, self._silence = WaitingScans(), ScanSilence(self._frames)
        self._reported = ""
        self._map_to_odom: Pose2D | None = None
        self._continuity = Continuity()
        self._restored: AmclState | None = None
        self._update_asked = False
        self._search_runs = False
        self._floors = FloorService(context, parameters)

    def start(self) -> None:
        """Watch from now on whether scans are used."""
        self.context.every(0.5 * SILENT, self._report_silence)

    def use_layers(self, layers: MapLayers) -> None:
        """Replace the map by another in the same frame, such as the next version, while the robot drives.

        The pose stays. A search of the last map for a lost robot is discarded, and begins again with the next scans.
        """
        self._info, self._layers = layers.grid.info, layers
        self._filter.use_layers(layers)
        self._tracker.use_layers(layers)

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a scan, a transform or an initial pose.

        Raises
        ------
        InvalidInput
            A number is not finite, a size is wrong, the pose is outside the map, or the scan is older than the last.
        TransformError
            The frame of a scan or of an initial pose is unknown, or its stamp is older than what tf keeps.
        """
        if topic == topics.SCAN.name:
            self._on_scan(expect(message, LaserScan))
        elif topic == topics.INITIAL_POSE.name:
            initial = read_initial_pose(expect(message, PoseWithCovarianceStamped), self._info, self._frames.names)
            self._filter.initialise(*initial)
            self._tracker.forget()
            self._restored = None
        elif topic == topics.BAROMETER.name:
            self._floors.heard(expect(message, FluidPressure))
        else:
            try:
                self._frames.hear(topic, expect(message, TFMessage), self.context.elapsed(), self.context.now())
            except PPaaSError as error:
                self._silence.transform_refused(error)
                raise
            finally:
                self._process_waiting()

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Search for the robot on the whole map, update with the next scan, or find its floor after a ride.

        Raises
        ------
        InvalidMap
            The map has no free cell.
        Unavailable, Conflict
            The robot localizes itself, or is not localized yet.
        """
        if not self._parameters.localize:
            kind = Conflict if service == FIND_FLOOR.name else Unavailable  # that is asked again while it may change
            raise kind("the robot localizes itself: parameter localize of amcl is false")
        if service == GLOBAL_LOCALIZATION.name:
            self._search_everywhere()
        elif isinstance(request, FindFloorRequest):
            at, odom = self._map_to_odom, self._continuity.odom
            self._floors.call(request, reply, None if at is None or odom is None else (at @ odom, odom))
            return
        else:
            self._update_asked = True
        reply(Empty())

    def _search_everywhere(self) -> None:
        self._filter.initialise_globally()
        self._tracker.forget()
        self._restored = None

    # -- scans ---------------------------------------------------------------------------------------------------------

    def _on_scan(self, message: LaserScan) -> None:
        if not self._parameters.localize:
            return
        self._silence.scan_came(self.context.elapsed())
        try:
            self._waiting.add(self._checked(message), self._frames.newest())
            errors = self._process_waiting()
            if errors:
                raise errors[-1]
        except PPaaSError as error:
            self._report(f"scans are refused: {error}")
            raise

    def _checked(self, message: LaserScan) -> RobotScan:
        scan = self._scans.read(message, self.context.elapsed())
        check_plausible(scan.scan, self._layers, lambda: self._in_map(scan.laser))
        if scan.stamp:
            self._continuity.check_stamp(scan.stamp, self._frames.newest(), scan.frame)
        return scan

    def _in_map(self, laser: Pose2D) -> Pose2D | None:
        """Return the estimated pose of the laser in the map frame, or None before the first estimate."""
        if self._map_to_odom is None:
            return None
        return self._map_to_odom @ self._frames.odometry() @ laser

    def _process_waiting(self) -> list[PPaaSError]:
        """Use the scans that odometry has reached; return the errors of those that cannot be used."""
        errors = self._waiting.process(self._frames.newest(), self.context.elapsed(), self._process)
        problem = self._silence.reason_ahead(self._waiting.problem, self.context.elapsed())
        if problem:
            self._report(problem)
        return errors

    def _process(self, scan: RobotScan, stamp: float) -> None:
        odom = self._frames.odometry(stamp)
        self._resume(odom, stamp)
        restarted = self._continuity.has_restarted(odom, self.context.elapsed())
        before = self._continuity.note(odom, stamp, self.context.elapsed(), scan.frame)
        if restarted:
            logger.warning("the odometry began anew after a silence: the robot is searched on the whole map")
            self._search_everywhere()
        elif before is not None:
            self._on_odometry_reset(before, odom)
        if self._update_asked or self._filter.needs_update(odom):
            self._update(scan, odom, stamp)
        elif self._tracker.due(odom, self.context.elapsed()):
            self._align(self._filter.sensor.hits(scan.scan, scan.laser, POINTS), odom)
        if self._floors.wants_scans:
            self._floors.scan(self._filter.sensor.hits(scan.scan, scan.laser, POINTS), odom)
        # The scan's own stamp to the nanosecond, as in ROS: a client finds the pose of a scan by it.
        self._publish_pose(odom, stamp, scan.scan.header.stamp if scan.stamp else Time.of(stamp))
        self._silence.scan_used(self.context.elapsed())
        self._report("")

    def _report_silence(self) -> None:
        """Report why no scan is used, unless scans are refused, which is reported with the reason already."""
        reason = self._silence.reason(self.context.elapsed())
        if reason and not self._reported:
            self._report(reason)

    def _report(self, text: str) -> None:
        """Publish the reason for which localization uses no scans, if it has changed; empty text while it uses them."""
        if text != self._reported:
            self._reported = text
            self.context.publish(topics.AMCL_STATUS.name, String(text))

    def _on_odometry_reset(self, before: Pose2D, odom: Pose2D) -> None:
        jump = before @ odom.inverse()
        self._filter.rebase(jump)
        self._tracker.rebase(jump)
        if self._map_to_odom is not None:
            self._map_to_odom = self._map_to_odom @ jump

    def _update(self, scan: RobotScan, odom: Pose2D, stamp: float) -> None:
        self._update_asked = False
        sensor = self._filter.sensor
        beams, hits = sensor.beams_and_hits(scan.scan, scan.laser, POINTS)
        self._filter.spread_heading(self._tracker.note_update(self.context.elapsed()))
        estimate = self._filter.update(odom, beams, sensor.range_max(scan.scan))
        self._map_to_odom = estimate.pose @ odom.inverse()
        self._align(hits, odom)
        self.context.publish(topics.PARTICLE_CLOUD.name, ParticleCloud(self._filter.particles, stamp))
        self._start_search()

    def _align(self, hits: NDArray[np.float64], odom: Pose2D) -> None:
        """Correct the pose of the particles by aligning a scan with the map; one that may be anywhere has none."""
        if self._filter.searching:
            self._tracker.forget()
            return
        pose = self._tracker.align(self._filter.expected(odom), odom, hits, self.context.elapsed())
        if pose is not None:
            self._filter.correct(odom, pose)
            self._map_to_odom = pose @ odom.inverse()

    def _start_search(self) -> None:
        """Start a search of the whole map for a lost robot, in a job: it takes longer than a control cycle."""
        search = None if self._search_runs else self._filter.next_search()
        if search is not None:
            self._search_runs = True
            self.context.start(search.run, self._on_found)

    def _on_found(self, found: PoseCandidates | PPaaSError | None) -> None:
        self._search_runs = False
        if isinstance(found, PPaaSError):
            logger.warning("the search for a lost robot failed: %s", found)
        elif found is not None and self._filter.adopt(found):
            self._update_asked = True
            self._tracker.forget()
        self._start_search()

    def _publish_pose(self, odom: Pose2D, stamp: float, moment: Time) -> None:
        assert self._map_to_odom is not None
        if self._parameters.tf_broadcast:
            good_until = Time.of(stamp + self._parameters.transform_tolerance)
            correction = transform_message(MAP, self._frames.odom, self._map_to_odom, good_until)
            self.context.publish(topics.TF.name, TFMessage([correction]))
        covariance = self._covariance()
        self.context.publish(topics.AMCL_POSE.name, pose_message(self._map_to_odom @ odom, covariance, moment))

    def _covariance(self) -> NDArray[np.float64]:
        """Return the covariance of the pose, with what the heading may have drifted since a scan last told it."""
        drifted = self._tracker.unsure(self.context.elapsed())
        return self._filter.estimate.covariance + np.diag((0.0, 0.0, drifted**2))

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes:
        """Return the pose of the robot as JSON."""
        if self._restored is not None:
            return msgspec.json.encode(self._restored)
        last, pose = self._continuity, self._filter.estimate.pose
        if self._map_to_odom is not None and last.odom is not None:
            pose = self._map_to_odom @ last.odom
        covariance, searching = self._covariance().tolist(), self._filter.searching
        state = AmclState((pose.x, pose.y, pose.theta), covariance, last.odom, searching, last.stamp)
        return msgspec.json.encode(state)

    def restore(self, state: bytes) -> None:
        """Continue from a checkpoint; the next odometry adds how far the robot has moved since."""
        self._restored = from_json(state, AmclState)
        self._filter.initialise(Pose2D(*self._restored.pose), np.array(self._restored.covariance))
        self._tracker.forget()

    def carry_over(self, state: bytes) -> None:
        """Begin at the initial pose, which is on the map of this container; the pose of the checkpoint is not."""

    def _resume(self, odom: Pose2D, stamp: float) -> None:
        """With the first odometry after a restore, add the motion that was missed, or resume the search."""
        if self._restored is None:
            return
        state, self._restored = self._restored, None
        if state.searching:
            self._filter.initialise_globally()
        elif state.odom is not None:
            before, since = Pose2D(*state.odom), None if state.stamp is None else stamp - state.stamp
            if has_driven(odom.distance_to(before), since):
                pose = Pose2D(*state.pose) @ before.inverse() @ odom
                self._filter.initialise(pose, np.array(state.covariance))
