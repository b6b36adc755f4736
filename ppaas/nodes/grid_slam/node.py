"""Node ``grid_slam``: makes a map of an unknown place and localizes the robot in it."""

import logging
from collections.abc import Callable
from functools import partial
from typing import ClassVar

from ppaas.errors import PPaaSError, QuotaExceeded, TransformError, Unavailable
from ppaas.geometry import Pose2D
from ppaas.mapping.live.closing_work import Closed
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.maps.grid import GridMap
from ppaas.maps.occupancy import to_message
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.messages.message import Empty, Message
from ppaas.messages.nav_msgs import GetMap, GetMapResponse
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.slam_toolbox import (
    Clear,
    DeserializePoseGraphRequest,
    Pause,
    PauseResponse,
    SaveMap,
    SaveMapRequest,
    SaveMapResponse,
    SaveMapResult,
)
from ppaas.messages.std_msgs import String, Time
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.nodes.amcl.continuity import Continuity
from ppaas.nodes.base import Context, Demands, Payload, Reply, Service, Topic
from ppaas.nodes.frames import MAP, FrameListener
from ppaas.nodes.grid_slam.laser import MappingLaser
from ppaas.nodes.grid_slam.logged_map import LoggedMapNode
from ppaas.nodes.grid_slam.map_publisher import MapPublisher
from ppaas.nodes.grid_slam.messages import no_map
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
from ppaas.nodes.jobs import LongWork
from ppaas.nodes.key_frame_path import KeyFramePublisher
from ppaas.nodes.message_checks import expect, finite_pose
from ppaas.nodes.robot_scans import RobotScan, ScanReader, WaitingScans

logger = logging.getLogger(__name__)

DYNAMIC_MAP = Service("dynamic_map", GetMap)
SAVE_MAP = Service("save_map", SaveMap)
CLEAR = Service("clear", Clear)
PAUSE = Service("pause", Pause)

MAP_PERIOD = 1.0
"""Time between two publications of changes of the map [s]."""

MapSaver = Callable[[str, GridMap, Callable[[PPaaSError | None], None]], None]
"""Saves a map by its name, then calls back with None or the error, now or later."""


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
    services: ClassVar[tuple[Service, ...]] = (DYNAMIC_MAP, SAVE_MAP, CLEAR, PAUSE, *GRAPH_SERVICES)

    def __init__(
        self,
        context: Context,
        parameters: GridSlamParameters,
        save: MapSaver | None = None,
        prepare: Callable[[], None] | None = None,
        *,
        graphs: PoseGraphStore = NO_STORE,
    ) -> None:
        super().__init__(context, parameters)
        self._save, self._prepare = save, prepare
        self._least_interval = parameters.least_interval
        self._frames = FrameListener(parameters.frames())
        self._scans, self._waiting = ScanReader(self._frames, warns=True), WaitingScans()
        self._publisher = MapPublisher(context, parameters.map_update_interval)
        self._poses = PosePublisher(context, self._frames, parameters)
        self._continuity, self._key_frames = Continuity(), KeyFramePublisher(context)
        self._others, self._reported = OtherRobots(), ""
        self._count, self._used_at = 0, float("-inf")
        self._graphs = PoseGraphServices(context, graphs, parameters.drawing())
        self._loads = bool(parameters.map_file_name) and graphs.load is not None  # otherwise it comes with the log

    def start(self) -> None:
        """Load the map that is continued, and publish changes of the map from now on.

        Raises
        ------
        NotFound, InvalidGraph
            The map of ``map_file_name`` has no pose graph, or one that cannot be read.
        """
        if self._loads:
            keeps = self._parameters.mode == "mapping"
            graph = self._graphs.load(self._parameters.map_file_name, self._parameters.start_pose, keeps=keeps)
            self._others.use_frame_of(graph.mapping.frames)
            self._continue(graph)
        self.context.every(MAP_PERIOD, self._publish_map)
        if (prepare := self._prepare) is not None:
            self.context.start(LongWork(lambda _cancelled: prepare()), self._on_prepared)

    def _on_prepared(self, outcome: PPaaSError | None) -> None:
        if outcome is not None:
            logger.warning("kernels of mapping are loaded at their first call: %s", outcome)
        self._prepare = None

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
            self._process_waiting()

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Reply with the map, save it, clear it, or pause and resume.

        Raises
        ------
        Unavailable
            Maps cannot be saved here.
        """
        if service == DYNAMIC_MAP.name:
            grid = self._grid()
            reply(GetMapResponse(no_map() if grid is None else to_message(grid, MAP, Time.of(self.context.now()))))
        elif service == SAVE_MAP.name:
            assert isinstance(request, SaveMapRequest)
            self._save_map(request.name.data, reply)
        elif service == CLEAR.name:
            self._clear()
            reply(Empty())
        elif service == DESERIALIZE.name:
            assert isinstance(request, DeserializePoseGraphRequest)
            self._continue(self._graphs.requested(request))
            reply(Empty())
        elif service in (SERIALIZE.name, POSE_GRAPH.name):
            self._graphs.answer(request, self._mapping(), reply)
        else:
            self._paused = not self._paused
            reply(PauseResponse(self._paused))

    # -- scans ---------------------------------------------------------------------------------------------------------

    def _on_scan(self, message: LaserScan) -> None:
        try:
            self._waiting.add(self._checked(message), self._frames.newest())
            errors = self._process_waiting()
            if errors:
                raise errors[-1]
        except PPaaSError as error:
            self._report(f"scans are refused: {error}")
            raise

    def _checked(self, message: LaserScan) -> RobotScan:
        scan, newest = self._scans.read(message, self.context.elapsed()), self._frames.newest()
        if self._laser is not None:
            self._laser.check(scan)
        if scan.stamp:
            self._continuity.check_stamp(scan.stamp, newest, scan.frame)
        if newest is None:
            self._report("scans wait for odometry: publish the transform of the robot in the odometry frame on 'tf'")
        return scan

    def _process_waiting(self) -> list[PPaaSError]:
        """Use the scans that odometry has reached; return the errors of those that cannot be used."""
        errors = self._waiting.process(self._frames.newest(), self.context.elapsed(), self._process)
        if self._waiting.problem:
            self._report(self._waiting.problem)
        return errors

    def _process(self, scan: RobotScan, stamp: float) -> None:
        odom = self._frames.odometry(stamp)
        before = self._continuity.note(odom, stamp, self.context.elapsed(), scan.frame)
        if before is not None:
            self._on_odometry_reset(before, odom)
        moment = scan.scan.header.stamp if scan.stamp else Time.of(stamp)
        if self._is_due(stamp):
            self._track(scan, odom, stamp, moment)
        if self._mapper is not None:
            self._poses.publish_transform(self._map_to_odom, stamp)
        self._report(self._problem())

    def _problem(self) -> str:
        """Return the reason for which scans or parts of the map are left out now; empty if there is none."""
        if self._prepare is not None:
            return "mapping is being prepared: scans are used in a moment"
        return "mapping is paused: call 'pause' to resume it" if self._paused else self._map_error

    def _is_due(self, stamp: float) -> bool:
        """Return whether a scan is to be used; count it."""
        if self._prepare is not None:
            return False
        self._count += 1
        if self._paused or (self._count - 1) % self._parameters.throttle_scans:
            return False
        if abs(stamp - self._used_at) < self._least_interval:
            return False
        self._used_at = stamp
        return True

    def _track(self, scan: RobotScan, odom: Pose2D, stamp: float, moment: Time) -> None:
        laser, mapper = self._started(scan)
        laser.check(scan)
        points, expected = laser.points(scan, odom, stamp), self._map_to_odom @ odom @ laser.geometry.mount
        points = self._others.cut_from(points, expected, mapper.key_frames, self.context.elapsed())
        tracked = mapper.add(points, odom)
        robot = tracked.pose @ laser.geometry.mount.inverse()
        self._map_to_odom = robot @ odom.inverse()
        self._poses.publish(tracked, robot, moment, shared=self._others.are_in(mapper.key_frames))
        if tracked.is_key:
            self._key_frames.add(mapper.key_frames, stamp)
            self._close_loops()

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

    def _report(self, text: str) -> None:
        """Publish the reason for which scans or parts of the map are left out, if it has changed; empty if none is."""
        if text != self._reported:
            self._reported = text
            self.context.publish(topics.GRID_SLAM_STATUS.name, String(text))

    # -- closures ------------------------------------------------------------------------------------------------------

    def _close_loops(self) -> None:
        """Start the search for closures that is due, in a job: no scan waits for it."""
        mapper = self._mapper
        if mapper is not None and (work := mapper.next_work()) is not None:
            self.context.start(LongWork(work), partial(self._on_closed, mapper))

    def _on_closed(self, mapper: LiveMapper, closed: Closed | PPaaSError | None) -> None:
        if mapper is not self._mapper:
            return  # the map was cleared meanwhile
        if isinstance(closed, PPaaSError):
            logger.warning("a search for loop closures failed: %s", closed)
            closed = None
        motion = mapper.apply(closed)
        if motion is not None:
            self._map_to_odom = motion @ self._map_to_odom
            self._publish_map()
            self._key_frames.publish(mapper.key_frames)
        self._close_loops()

    # -- map -----------------------------------------------------------------------------------------------------------

    def _publish_map(self) -> None:
        if self._mapper is None:
            return
        try:
            canvas = self._mapper.draw()
        except QuotaExceeded as error:
            self._map_error = f"the map is not complete: {error}"
            self._report(self._map_error)
            return
        self._publisher.publish(canvas)

    def _grid(self) -> GridMap | None:
        """Return a copy of the map; None if there is none yet.

        Raises
        ------
        QuotaExceeded
            The map would be too large.
        """
        if self._mapper is None:
            return None
        canvas = self._mapper.draw()
        return None if canvas.extent is None else GridMap(canvas.cells.copy(), canvas.info)

    def _save_map(self, name: str, reply: Reply) -> None:
        if self._save is None:
            raise Unavailable("maps cannot be saved here: get the map by 'dynamic_map'")
        grid = self._grid()
        if grid is None:
            reply(SaveMapResponse(SaveMapResult.RESULT_NO_MAP_RECEIEVD))
            return
        self._save(name, grid, lambda error: reply(error or SaveMapResponse(SaveMapResult.RESULT_SUCCESS)))

    def _clear(self) -> None:
        """Forget the map; the next scan starts another one, in the frame of the odometry."""
        self._laser = self._mapper = None
        self._map_to_odom, self._count, self._used_at = Pose2D(0.0, 0.0, 0.0), 0, float("-inf")
        self._map_error = ""
        self._logbook.end()
        self._publisher.forget()
        self._key_frames.clear()
        self._graphs.forget()

    # -- mappings that are kept ----------------------------------------------------------------------------------------

    def _continue(self, graph: LoadedGraph) -> None:
        """Continue another mapping, or localize in it, instead of the current one."""
        laser = MappingLaser(graph.mapping.laser_frame, graph.mapping.frames.geometry, self._front_end)
        mapper = self._new_mapper(laser)
        first = Pose2D(*graph.mapping.frames.poses[0].tolist()) @ laser.geometry.mount.inverse()
        mapper.load(graph.mapping, first if graph.start is None else graph.start, keeps=graph.keeps)
        self._clear()
        self._laser, self._mapper = laser, mapper
        if graph.keeps:
            self._logbook.begin(laser.frame)

    def _on_initial_pose(self, message: PoseWithCovarianceStamped) -> None:
        """Search the next scan around a pose; without effect before there is a map."""
        if not self._frames.names.is_map(message.header.frame_id):
            raise TransformError(f"an initial pose must be in frame {MAP!r}, not {message.header.frame_id!r}")
        pose = finite_pose(message.pose.pose, "an initial pose")
        if self._mapper is not None and len(self._mapper.key_frames):
            self._mapper.place(pose)
