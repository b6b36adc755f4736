"""Node ``grid_slam``: makes a map of an unknown place and localizes the robot in it."""

import logging
from collections.abc import Callable
from functools import partial
from typing import ClassVar, NamedTuple

from ppaas.errors import PPaaSError, TransformError
from ppaas.geometry import Pose2D
from ppaas.mapping.live.joint_mapper import Adoption
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.slam_toolbox import (
    Clear,
    DeserializePoseGraphRequest,
    Pause,
    PauseResponse,
    UseJointMapRequest,
)
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Demands, Payload, Reply, Service, Topic
from ppaas.nodes.frames import MAP
from ppaas.nodes.grid_slam.joint_maps import USE_JOINT_MAP, JointMaps
from ppaas.nodes.grid_slam.laser import MappingLaser
from ppaas.nodes.grid_slam.logged_map import draw
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
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
from ppaas.nodes.grid_slam.publishing import DYNAMIC_MAP, SAVE_MAP, MapSaver
from ppaas.nodes.grid_slam.publishing import SERVICES as MAP_SERVICES
from ppaas.nodes.grid_slam.scan_mapping import Preparation, ScanMappingNode
from ppaas.nodes.message_checks import expect, finite_pose

logger = logging.getLogger(__name__)

CLEAR = Service("clear", Clear)
PAUSE = Service("pause", Pause)


class LoadedMap(NamedTuple):
    """Map of a mapping that was loaded.

    Parameters
    ----------
    laser : MappingLaser
    mapper : LiveMapper
    """

    laser: MappingLaser
    mapper: LiveMapper


class GridSlamNode(ScanMappingNode):
    """Subscribes to scans and ``tf``; publishes the map, ``pose``, ``entropy``, and ``tf`` map → odom with each scan.

    The pose is published as ``amcl_pose`` too, so that clients find it there whether or not the map is published yet.

    It behaves as gmapping and slam_toolbox. The map frame is the odometry frame at the first scan. Scans are tracked as
    they come. Loop closures are searched for in jobs; their results move the key frames, the map and the robot.

    Scans wait until odometry has reached their stamps. If the odometry is reset, the robot is assumed not to have
    moved. A robot that sends scans alone is mapped without odometry (`ScanOdometry`). While no scan can be used, or the
    map is not complete, ``grid_slam/status`` gives the reason.

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
        topics.SCAN, topics.ODOM, topics.TF, topics.TF_STATIC, topics.INITIAL_POSE, topics.ROBOTS,
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
        prepare: Preparation | None = None,
        *,
        graphs: PoseGraphStore = NO_STORE,
        prepare_closures: Preparation | None = None,
    ) -> None:
        super().__init__(context, parameters, save, prepare, prepare_closures)
        self._graphs = PoseGraphServices(context, graphs, parameters.drawing(), closes=parameters.do_loop_closing)
        self._joint_maps = JointMaps(context, self._joinable, self._logbook, self._on_joined, self._closures.start)
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
        super().start()

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a scan or a transform.

        Raises
        ------
        InvalidInput
            A number is not finite, the beams differ from the map's, or the scan is older than the last.
        TransformError
            The frame of a scan is unknown, or its stamp is older than what tf keeps.
        QuotaExceeded
            The map has as many key frames as allowed.
        """
        if topic == topics.SCAN.name:
            self._on_scan(expect(message, LaserScan))
            return
        if topic == topics.ODOM.name:
            self._intake.scan_odometry.odometry_came()
            return
        if topic == topics.ROBOTS.name:
            self._others.hear(message, self.context.elapsed())
            return
        if topic == topics.INITIAL_POSE.name:
            self._on_initial_pose(expect(message, PoseWithCovarianceStamped))
            return
        self._on_transforms(topic, expect(message, TFMessage))

    def _on_transforms(self, topic: str, message: TFMessage) -> None:
        try:
            self._frames.hear(topic, message, self.context.elapsed(), self.context.now())
        finally:
            before = self._intake.scan_odometry.heard(message)
            if before is not None:
                self._change_odometry(before)
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

    # -- mappings that are kept ----------------------------------------------------------------------------------------

    def _clear(self) -> None:
        """Forget the map; the next scan starts another one, in the frame of the odometry."""
        self._laser = self._mapper = None
        self._map_to_odom, self._map_error = Pose2D(0.0, 0.0, 0.0), ""
        self._intake.restart()
        self._logbook.end()
        self._maps.forget()
        self._key_frames.clear()
        self._graphs.forget()

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
