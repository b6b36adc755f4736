"""Node ``grid_slam``: makes a map of an unknown place and localizes the robot in it."""

import logging
from collections.abc import Callable
from functools import partial
from typing import ClassVar, NamedTuple

from ppaas.errors import PPaaSError, TransformError
from ppaas.geometry import Pose2D
from ppaas.mapping.live.joint_mapper import Adoption
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.messages.message import Empty, Message
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.slam_toolbox import (
    Clear,
    DeserializePoseGraphRequest,
    Pause,
    PauseResponse,
    UseJointMapRequest,
)
from ppaas.messages.std_msgs import Time
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Demands, Payload, Reply, Service, Topic
from ppaas.nodes.frames import MAP, FrameListener
from ppaas.nodes.grid_slam.closure_jobs import ClosureJobs
from ppaas.nodes.grid_slam.joint_maps import USE_JOINT_MAP, JointMaps
from ppaas.nodes.grid_slam.laser import MappingLaser
from ppaas.nodes.grid_slam.logged_map import LoggedMapNode
from ppaas.nodes.grid_slam.map_services import DYNAMIC_MAP, SAVE_MAP, MapSaver, MapServices
from ppaas.nodes.grid_slam.map_services import SERVICES as MAP_SERVICES
from ppaas.nodes.grid_slam.other_robots import OtherRobots
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.nodes.grid_slam.pose_publisher import PosePublisher
from ppaas.nodes.grid_slam.posegraph_services import (
    DESERIALIZE,
    NO_STORE,
    POSE_GRAPH,
    SERIALIZE,
    LoadedGraph,
    PoseGraphServices,
    PoseGraphStore,
)
from ppaas.nodes.grid_slam.posegraph_services import SERVICES as GRAPH_SERVICES
from ppaas.nodes.grid_slam.restoration import draw
from ppaas.nodes.grid_slam.scan_intake import ScanIntake
from ppaas.nodes.grid_slam.status import StatusPublisher, lost_status
from ppaas.nodes.jobs import LongWork
from ppaas.nodes.key_frame_path import KeyFramePublisher
from ppaas.nodes.message_checks import expect, finite_pose
from ppaas.nodes.robot_scans import RobotScan

logger = logging.getLogger(__name__)

CLEAR = Service("clear", Clear)
PAUSE = Service("pause", Pause)

MAP_PERIOD = 1.0
"""Time between two publications of changes of the map [s]."""


class LoadedMap(NamedTuple):
    """Map of a mapping that was loaded.

    Parameters
    ----------
    laser : MappingLaser
    mapper : LiveMapper
    """

    laser: MappingLaser
    mapper: LiveMapper


class GridSlamNode(LoggedMapNode):
    """Subscribes to scans and ``tf``; publishes the map, ``pose``, ``entropy``, and ``tf`` map → odom with each scan.

    The pose is published as ``amcl_pose`` too, so that clients find it there whether or not the map is published yet.

    It behaves as gmapping and slam_toolbox. The map frame is the odometry frame at the first scan. Scans are tracked as
    they come. Loop closures are searched for in jobs; their results move the key frames, the map and the robot.

    Scans wait until odometry has reached their stamps. If the odometry is reset, the robot is assumed not to have
    moved. While no scan can be used, or the map is not complete, ``grid_slam/status`` gives the reason.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : GridSlamParameters
        Named as in slam_toolbox and gmapping.
    save : callable, optional
        Saves a map for ``save_map``; without it the service is unavailable.
    prepare : callable, optional
        Run in a job, such as the loading of kernels, before any scan is used.
    graphs : PoseGraphStore
        What pose graphs are saved to and loaded from.
    prepare_closures : callable, optional
        Run in a job once scans are used, such as the loading of kernels that only the search for closures needs.
    """

    name: ClassVar[str] = "grid_slam"
    demands: ClassVar[Demands] = Demands(0.3, rates={topics.SCAN.name: topics.SCAN_RATE})
    subscribes: ClassVar[tuple[Topic, ...]] = (
        topics.SCAN, topics.TF, topics.TF_STATIC, topics.INITIAL_POSE, topics.ROBOTS,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (
        topics.TF, topics.MAP, topics.MAP_METADATA, topics.MAP_UPDATES, topics.SLAM_POSE, topics.AMCL_POSE,
        topics.ENTROPY, topics.GRID_SLAM_STATUS, topics.KEY_FRAMES, topics.SHARED_POSE,
    )  # fmt: skip
    services: ClassVar[tuple[Service, ...]] = (*MAP_SERVICES, CLEAR, PAUSE, *GRAPH_SERVICES, USE_JOINT_MAP)

    def __init__(
        self,
        context: Context,
        parameters: GridSlamParameters,
        save: MapSaver | None = None,
        prepare: Callable[[], None] | None = None,
        *,
        graphs: PoseGraphStore = NO_STORE,
        prepare_closures: Callable[[], None] | None = None,
    ) -> None:
        super().__init__(context, parameters)
        self._prepare, self._prepare_closures = prepare, prepare_closures
        self._frames, self._status = FrameListener(parameters.frames()), StatusPublisher(context)
        self._intake = ScanIntake(context, self._frames, parameters, self._status)
        self._maps = MapServices(context, parameters.map_update_interval, save)
        self._poses = PosePublisher(context, self._frames, parameters)
        self._key_frames, self._others = KeyFramePublisher(context, self._logbook.times), OtherRobots()
        self._closures = ClosureJobs(context, lambda: self._mapper, self._on_moved)
        self._graphs = PoseGraphServices(context, graphs, parameters.drawing(), closes=parameters.do_loop_closing)
        self._joint_maps = JointMaps(context, self._joinable, self._logbook, self._on_joined)
        self._loads = bool(parameters.map_file_name) and graphs.load is not None  # otherwise it comes with the log

    def start(self) -> None:
        """Load the map that is continued, and publish changes of the map from now on.

        Raises
        ------
        NotFound, InvalidGraph
            The map of ``map_file_name`` has no pose graph, or one that cannot be read.
        """
        if self._loads:
            keeps = self._parameters.mode != "localization"
            load = self._graphs.loading(self._parameters.map_file_name, self._parameters.start_pose, keeps=keeps)
            graph = load()
            self._others.use_frame_of(graph.mapping.frames)
            self._use(self._loaded(graph))
        for name in self._parameters.unused:
            logger.info("parameter %r of grid_slam has no effect: see 'lifelong_iou_match'", name)
        self.context.every(MAP_PERIOD, self._publish_map)
        if (prepare := self._prepare) is not None:
            self.context.start(LongWork(lambda _cancelled: prepare()), self._on_prepared)

    def _on_prepared(self, outcome: PPaaSError | None) -> None:
        _warn_of(outcome)
        self._prepare = None
        self._begin()

    def _begin(self) -> None:
        """Use the scans that have waited, if nothing else is missing."""
        self._use_scans()
        if self._is_ready and (prepare := self._prepare_closures) is not None:
            self._prepare_closures = None
            self.context.start(LongWork(lambda _cancelled: prepare()), _warn_of)

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a scan or a transform.

        Raises
        ------
        InvalidInput
            A number is not finite, the beams are not those of the map, or the scan is older than the last.
        TransformError
            The frame of a scan is unknown, or its stamp is older than what tf keeps.
        QuotaExceeded
            The map has as many key frames as allowed.
        """
        if topic == topics.SCAN.name:
            self._on_scan(expect(message, LaserScan))
            return
        if topic == topics.ROBOTS.name:
            self._others.hear(message, self.context.elapsed())
            return
        if topic == topics.INITIAL_POSE.name:
            self._on_initial_pose(expect(message, PoseWithCovarianceStamped))
            return
        try:
            self._frames.hear(topic, expect(message, TFMessage), self.context.elapsed(), self.context.now())
        finally:
            self._use_scans()

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Reply with the map, save it, clear it, continue another one, or pause. Calls wait while a map is loaded."""
        self._jobs.run(partial(self._answer, service, request, reply))

    def _answer(self, service: str, request: Message, reply: Reply) -> None:
        try:
            self._serve(service, request, reply)
        except PPaaSError as error:
            reply(error)

    def _serve(self, service: str, request: Message, reply: Reply) -> None:
        if service in (DYNAMIC_MAP.name, SAVE_MAP.name):
            self._maps.answer(request, self._mapper, reply)
        elif service == CLEAR.name:
            self._clear()
            reply(Empty())
        elif service == DESERIALIZE.name:
            assert isinstance(request, DeserializePoseGraphRequest)
            self._continue(self._graphs.requested(request), reply)
        elif service in (SERIALIZE.name, POSE_GRAPH.name):
            self._graphs.answer(request, self._current_part(request), reply, may_join=self._joinable() is not None)
        elif service == USE_JOINT_MAP.name:
            assert isinstance(request, UseJointMapRequest)
            self._joint_maps.receive(request, reply)
        else:
            self._paused = not self._paused
            reply(PauseResponse(self._paused))

    # -- scans ---------------------------------------------------------------------------------------------------------

    def _on_scan(self, message: LaserScan) -> None:
        try:
            self._intake.add(message, self._laser)
            errors = self._use_scans()
            if errors:
                raise errors[-1]
            if not self._is_ready:
                self._report_waiting()
        except PPaaSError as error:
            self._status.report(f"scans are refused: {error}")
            raise

    @property
    def _is_ready(self) -> bool:
        """Whether scans are used; until then they wait."""
        return self._prepare is None and self._restoration is None

    def _use_scans(self) -> list[PPaaSError]:
        """Use the scans that odometry has reached; return the errors of those that cannot be used."""
        return self._intake.process(self._process) if self._is_ready else []

    def _report_waiting(self) -> None:
        """Report why scans wait. If the robot has a map, it is where its odometry says."""
        newest = self._frames.newest()
        if newest is not None:
            self._status.report(self._problem())
            if self._restoration is not None or self._mapper is not None:
                self._poses.publish_transform(self._map_to_odom, newest)

    def _process(self, scan: RobotScan, stamp: float) -> None:
        odom, before = self._intake.odometry(scan, stamp)
        if before is not None:
            self._on_odometry_reset(before, odom)
        moment = scan.scan.header.stamp if scan.stamp else Time.of(stamp)
        if not self._paused and self._intake.is_due(stamp):
            self._track(scan, odom, stamp, moment)
        if self._mapper is not None:
            self._poses.publish_transform(self._map_to_odom, stamp)
        self._status.report(self._problem())

    def _problem(self) -> str:
        """Return the reason for which scans or parts of the map are left out now; empty if there is none."""
        if self._prepare is not None:
            return "mapping is being prepared: scans are used in a moment"
        if self._restoration is not None:
            return "the map is being restored: scans are used in a moment"
        if self._paused:
            return "mapping is paused: call 'pause' to resume it"
        return self._maps.problem or self._map_error or lost_status(self._mapper)

    def _track(self, scan: RobotScan, odom: Pose2D, stamp: float, moment: Time) -> None:
        laser, mapper = self._started(scan)
        laser.check(scan)
        points, expected = laser.points(scan, odom, stamp), self._map_to_odom @ odom @ laser.geometry.mount
        if is_shared := self._is_shared(mapper):
            points = self._others.cut_from(points, expected, mapper.key_frames, self.context.elapsed())
        tracked = mapper.add(points, odom)
        if tracked.is_lost:
            logger.warning("the robot was carried away: it maps another part until it recognizes a place")
            self._maps.forget()
            self._key_frames.clear()
        robot = tracked.pose @ laser.geometry.mount.inverse()
        self._map_to_odom = robot @ odom.inverse()
        shared = self._others.frame if is_shared and not tracked.is_lost else None
        self._poses.publish(tracked, robot, moment, shared=shared)
        if tracked.is_key:
            self._key_frames.add(mapper.key_frames, stamp)
            self._closures.start()

    def _started(self, scan: RobotScan) -> tuple[MappingLaser, LiveMapper]:
        """Return the laser and the mapper, made for the first scan."""
        if self._laser is None or self._mapper is None:
            self._laser = MappingLaser.of(scan, self._front_end)
            self._mapper = self._new_mapper(self._laser)
            self._logbook.begin(self._laser.frame)
        return self._laser, self._mapper

    def _on_odometry_reset(self, before: Pose2D, odom: Pose2D) -> None:
        self._map_to_odom = self._map_to_odom @ before @ odom.inverse()
        if self._mapper is not None and self._laser is not None:
            self._mapper.rebase(odom)
            self._laser.forget_motion()

    # -- map -----------------------------------------------------------------------------------------------------------

    def _on_moved(self, motion: Pose2D) -> None:
        """Publish the map that loop closures have moved; ``tf`` changes with the next scan."""
        self._map_to_odom = motion @ self._map_to_odom
        self._publish_map()
        if self._mapper is not None:
            self._key_frames.publish(self._mapper.key_frames)

    def _publish_map(self) -> None:
        if self._mapper is not None:
            self._maps.publish(self._mapper)
            if self._maps.problem:
                self._status.report(self._maps.problem)

    def _clear(self) -> None:
        """Forget the map; the next scan starts another one, in the frame of the odometry."""
        self._laser = self._mapper = None
        self._map_to_odom, self._map_error = Pose2D(0.0, 0.0, 0.0), ""
        self._intake.restart()
        self._logbook.end()
        self._maps.forget()
        self._key_frames.clear()
        self._graphs.forget()

    # -- mappings that are kept ----------------------------------------------------------------------------------------

    def _is_shared(self, mapper: LiveMapper) -> bool:
        return mapper.parts.current == 0 and self._others.are_in(mapper.key_frames)

    def _restored(self, mapper: LiveMapper, *, shared: bool) -> None:
        if shared:
            self._others.use_frame_of(mapper.key_frames, self._frame_name(mapper))
        self._key_frames.publish(mapper.key_frames)

    def _ready(self) -> None:
        self._publish_map()
        self._begin()

    def _continue(self, load: Callable[[], LoadedGraph], reply: Reply) -> None:
        """Load another mapping in a job, and continue it or localize in it, instead of the current one."""

        def loaded(result: LoadedMap | PPaaSError) -> None:
            if isinstance(result, PPaaSError):
                reply(result)
            else:
                self._use(result)
                reply(Empty())

        self._jobs.start(lambda _cancelled: self._loaded(load()), loaded)

    def _loaded(self, graph: LoadedGraph) -> LoadedMap:
        """Return the map of a mapping; nothing of the node is changed."""
        laser = MappingLaser(graph.mapping.laser_frame, graph.mapping.frames.geometry, self._front_end)
        mapper = self._new_mapper(laser)
        first = Pose2D(*graph.mapping.frames.poses[0].tolist()) @ laser.geometry.mount.inverse()
        mapper.load(graph.mapping, first if graph.start is None else graph.start, keeps=graph.keeps)
        draw(mapper)
        return LoadedMap(laser, mapper)

    def _use(self, loaded: LoadedMap) -> None:
        """Use another map instead of the current one."""
        self._clear()
        self._laser, self._mapper = loaded
        if loaded.mapper.keeps:
            self._logbook.begin(loaded.laser.frame)

    def _on_joined(self, adoption: Adoption, text: str) -> None:
        """Go on in the frame of a joint map: pose, map and key frames move at once, and goals with the key frames."""
        mapper = self._mapper
        assert mapper is not None
        self._key_frames.renumber(adoption.before, adoption.after)
        self._others.use_frame_of(mapper.key_frames, self._frame_name(mapper))
        self._poses.publish_jump(adoption.motion @ self._map_to_odom)
        self._on_moved(adoption.motion)
        self._closures.start()
        if text:
            self._status.report(text)

    def _on_initial_pose(self, message: PoseWithCovarianceStamped) -> None:
        """Search the next scan around a pose; without effect before there is a map."""
        if not self._frames.names.is_map(message.header.frame_id):
            raise TransformError(f"an initial pose must be in frame {MAP!r}, not {message.header.frame_id!r}")
        pose = finite_pose(message.pose.pose, "an initial pose")
        self._jobs.run(partial(self._place, pose))

    def _place(self, pose: Pose2D) -> None:
        if self._mapper is not None and len(self._mapper.key_frames):
            self._mapper.place(pose)


def _warn_of(outcome: PPaaSError | None) -> None:
    if outcome is not None:
        logger.warning("kernels of mapping are loaded at their first call: %s", outcome)
