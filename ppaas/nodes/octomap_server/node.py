"""Node ``octomap_server``: makes a 3D map of point clouds and depth images."""

from collections.abc import Sequence
from functools import partial
from typing import Any, ClassVar

import msgspec

from ppaas.change_log import LogChange, LogEntry
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, PPaaSError
from ppaas.mapping.volume.key_frame_poses import KeyFramePoses
from ppaas.maps.occupancy import GridMapMessage
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.base.std_msgs import String, Time
from ppaas.messages.octomap_msgs import (
    BoundingBoxQuery,
    BoundingBoxQueryRequest,
    GetOctomap,
    GetOctomapFile,
    GetOctomapFileRequest,
    GetOctomapFileResponse,
    GetOctomapResponse,
)
from ppaas.messages.sensor_msgs import CameraInfo, CompressedImage, Image, PointCloud2
from ppaas.messages.std_srvs import EmptyService
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node, Payload, Reply, Service, Topic
from ppaas.nodes.depth_images import DepthLens
from ppaas.nodes.file_pages import FilePages
from ppaas.nodes.frames import MAP, FrameListener, FrameNames
from ppaas.nodes.key_frame_path import key_frames_of
from ppaas.nodes.message_checks import expect
from ppaas.nodes.octomap_server.job_queue import JobQueue
from ppaas.nodes.octomap_server.map_work import CloudPoses, MapLog, MapWork, RenderedMaps
from ppaas.nodes.octomap_server.messages import CloudReader, OctomapFile, SensorCloud, poses_of
from ppaas.nodes.octomap_server.parameters import OctomapServerParameters
from ppaas.nodes.robot_scans import WaitingData
from ppaas.thread_budget import Threads, one_thread

OCTOMAP_BINARY = Service("octomap_binary", GetOctomap)
OCTOMAP_FULL = Service("octomap_full", GetOctomap)
CLEAR_BBX = Service("octomap_server/clear_bbx", BoundingBoxQuery)
CLEAR_BBOX = Service("octomap_server/clear_bbox", BoundingBoxQuery)
RESET = Service("octomap_server/reset", EmptyService)
FILE = Service("octomap_server/file", GetOctomapFile)

MAP_PERIOD = 1.0
"""Time between two publications of the map [s]."""

LOG_PERIOD = 3.0
"""Time between two changes of the log [s]; clouds of this time are lost with a container."""

MOST_WAITING = 5
"""Largest number of clouds that wait for transforms, as in octomap_server."""

MOST_QUEUED = 2
"""Largest number of clouds that wait for others to be inserted."""

MAPS = (topics.OCTOMAP_BINARY.name, topics.OCTOMAP_FULL.name, topics.PROJECTED_MAP.name)
"""Topics of the maps."""


class OctomapServerNode(Node):
    """Subscribes to point clouds, depth images and ``tf``; publishes 3D maps, and a projected 2D map.

    It behaves as ``octomap_server``. Clouds wait for the transform at their stamps. They are inserted in jobs, one
    after the other; if they come faster, the oldest are left out. Maps are published once a second if they have
    changed and somebody subscribes.

    While ``grid_slam`` makes the 2D map, clouds hang on its key frames and move with them when it closes a loop. The
    map is in a log beside the checkpoint.
    ``octomap_server/status`` gives the reason for which clouds are left out.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : OctomapServerParameters
        Named as in octomap_server.
    threads : callable
        Returns the largest number of threads that kernels may use now.
    names : FrameNames, optional
        Names of the robot's frames; by default from the parameters.

    Raises
    ------
    Unavailable
        Clouds are to be registered, and the library for it is not installed.
    """

    name: ClassVar[str] = "octomap_server"
    subscribes: ClassVar[tuple[Topic, ...]] = (
        topics.CLOUD_IN, topics.DEPTH_IMAGE, topics.COMPRESSED_DEPTH_IMAGE, topics.DEPTH_CAMERA_INFO, topics.TF,
        topics.TF_STATIC, topics.KEY_FRAMES,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (
        topics.OCTOMAP_BINARY, topics.OCTOMAP_FULL, topics.PROJECTED_MAP, topics.OCTOMAP_SERVER_STATUS,
    )  # fmt: skip
    keeps_log: ClassVar[bool] = True
    services: ClassVar[tuple[Service, ...]] = (
        OCTOMAP_BINARY, OCTOMAP_FULL, CLEAR_BBX, CLEAR_BBOX, RESET, FILE,
    )  # fmt: skip

    def __init__(
        self,
        context: Context,
        parameters: OctomapServerParameters,
        threads: Threads = one_thread,
        names: FrameNames | None = None,
    ) -> None:
        super().__init__(context)
        own = parameters
        self._parameters, self._work = own, MapWork(own, threads)
        self._frames = FrameListener(
            names or FrameNames.of(own.odom_frame_id, own.base_frame_id, own.frame_id, own.tf_prefix)
        )
        self._reader, self._poses = CloudReader(), CloudPoses(self._frames)
        self._waiting: WaitingData[SensorCloud] = WaitingData("clouds", MOST_WAITING)
        self._jobs, self._pages = JobQueue(context, MOST_QUEUED), FilePages("octomap")
        self._revision, self._published = 0, dict.fromkeys(MAPS, 0)
        self._rendering, self._reported, self._limit = False, "", ""
        self._log = MapLog(self._jobs, self._work)

    def start(self) -> None:
        """Publish maps from now on."""
        self.context.every(MAP_PERIOD, self._publish_maps)
        self.context.every(LOG_PERIOD, lambda: self._log.write(self._revision, self._poses.key_frames))

    def checkpoint(self) -> bytes | None:
        """Return the camera's parameters, which a robot may publish only once. The map is in the log."""
        return msgspec.json.encode(self._reader.camera) if self._reader.camera is not None else None

    def restore(self, state: bytes) -> None:
        """Use the camera's parameters of a checkpoint."""
        self._reader.camera = from_json(state, DepthLens)

    # -- log -----------------------------------------------------------------------------------------------------------

    def log_change(self) -> LogChange | None:
        """Return the change of the log of the map, as it was at most `LOG_PERIOD` ago."""
        return self._log.take()

    def restore_log(self, entries: Sequence[LogEntry]) -> None:
        """Continue the map of a log, which is read in a job; clouds wait for it.

        If it cannot be read, ``octomap_server/status`` reports that, and the map is lost.
        """
        self._log.restore(entries, self._on_restored)

    def _on_restored(self, key_frames: KeyFramePoses | None) -> None:
        self._revision += 1
        if key_frames is None:
            self._report(self._log.loss)
        elif len(key_frames) and len(self._poses.key_frames):
            self._jobs.add(partial(self._work.correct, key_frames, self._poses.key_frames), self._on_changed)
        elif len(key_frames):
            self._poses.set_key_frames(key_frames)

    # -- messages and calls --------------------------------------------------------------------------------------------

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a cloud, an image, a ``camera_info``, transforms or key frames.

        Raises
        ------
        InvalidInput
            The cloud or image is malformed, a ``camera_info`` is invalid or missing, or a number is not finite.
        TransformError
            A transform is invalid.
        """
        if topic == topics.KEY_FRAMES.name:
            self._on_key_frames(key_frames_of(message))
        elif topic == topics.DEPTH_CAMERA_INFO.name:
            self._reader.set_camera(expect(message, CameraInfo))
        elif topic in (topics.TF.name, topics.TF_STATIC.name):
            try:
                self._frames.hear(topic, expect(message, TFMessage), self.context.elapsed(), self.context.now())
            finally:
                self._process_waiting()
        else:
            self._on_cloud(topic, message)

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Reply with the map or a page of its file, clear a box of it, or forget it.

        Raises
        ------
        InvalidInput
            The page does not exist, or key frames are not poses.
        """
        if service in (OCTOMAP_BINARY.name, OCTOMAP_FULL.name):
            self._jobs.add(partial(self._work.render, [service]), partial(self._reply_map, reply))
        elif service == FILE.name:
            assert isinstance(request, GetOctomapFileRequest)
            if request.offset:
                reply(GetOctomapFileResponse(*self._pages.page(request.offset)))
            else:
                moves = (poses_of(request.before, "before"), poses_of(request.after, "after"))
                if len(moves[0]) != len(moves[1]):
                    raise InvalidInput("before and after must be poses of the same key frames")
                self._jobs.add(
                    partial(self._work.file, self._poses.key_frames, *moves), partial(self._reply_file, reply)
                )
        elif service == RESET.name:
            self._jobs.add(self._work.clear, partial(self._reply_change, reply))
        else:
            assert isinstance(request, BoundingBoxQueryRequest)
            low, high = ((point.x, point.y, point.z) for point in (request.min, request.max))
            self._jobs.add(partial(self._work.clear_box, low, high), partial(self._reply_change, reply))

    # -- clouds --------------------------------------------------------------------------------------------------------

    def _on_cloud(self, topic: str, message: Payload) -> None:
        now = self.context.elapsed()
        cloud: SensorCloud | None
        if topic == topics.CLOUD_IN.name:
            cloud = self._reader.of_points(expect(message, PointCloud2), now)
        elif topic == topics.DEPTH_IMAGE.name:
            cloud = self._reader.of_image(expect(message, Image), now)
        else:
            cloud = self._reader.of_image(expect(message, CompressedImage), now)
        if cloud is None:
            return
        newest = self._poses.newest()
        if newest is None:
            self._report("clouds wait for the pose of the robot in the map: publish odometry and localize the robot")
        self._waiting.add(cloud, newest)
        errors = self._process_waiting()
        if errors:
            raise errors[-1]

    def _process_waiting(self) -> list[PPaaSError]:
        """Use the clouds whose transforms have come; return the errors of those that cannot be used."""
        errors = self._waiting.process(self._poses.newest(), self.context.elapsed(), self._insert)
        if errors or self._waiting.problem:
            self._report(f"clouds are left out: {errors[-1]}" if errors else self._waiting.problem)
        return errors

    def _insert(self, cloud: SensorCloud, stamp: float) -> None:
        placed = self._poses.place(cloud, stamp)
        self._jobs.add(partial(self._work.insert, placed), self._on_inserted, may_be_dropped=True)

    def _on_inserted(self, result: str | PPaaSError) -> None:
        if isinstance(result, PPaaSError):
            self._report(f"clouds are left out: {result}")
            return
        self._revision += 1
        self._limit = result
        slow = "clouds are left out: they come faster than they are inserted, so send fewer or smaller ones"
        self._report(result or (slow if self._jobs.dropped else self._log.loss))
        self._jobs.dropped = 0

    def _report(self, text: str) -> None:
        """Publish the reason for which clouds are left out, if it has changed; empty if none is."""
        if text != self._reported:
            self._reported = text
            self.context.publish(topics.OCTOMAP_SERVER_STATUS.name, String(text))

    # -- key frames ----------------------------------------------------------------------------------------------------

    def _on_key_frames(self, after: KeyFramePoses) -> None:
        before = self._poses.key_frames
        self._poses.set_key_frames(after)
        if len(before) and not len(after):
            self._jobs.add(self._work.clear, self._on_changed)  # the 2D map was cleared, and its frame is another
        elif len(before) and after.differs(before):
            self._jobs.add(partial(self._work.correct, before, after), self._on_changed)
        self._process_waiting()

    def _on_changed(self, result: bool | PPaaSError | None) -> None:
        if isinstance(result, PPaaSError):
            self._report(f"the map could not be moved with the key frames: {result}")
        else:
            self._revision += 1

    # -- maps ----------------------------------------------------------------------------------------------------------

    def _publish_maps(self) -> None:
        """Publish the maps that have changed since they were last published and that somebody subscribes to."""
        due = [name for name in MAPS if self._published[name] != self._revision]
        wanted = [name for name in due if self.context.has_subscribers(name)]
        if not self._parameters.latch:
            self._published |= dict.fromkeys(due, self._revision)  # a later subscriber waits for the next change
        if wanted and not self._rendering:
            self._rendering = True
            self._jobs.add(partial(self._work.render, wanted), partial(self._on_rendered, wanted, self._revision))

    def _on_rendered(self, names: list[str], revision: int, result: RenderedMaps | PPaaSError) -> None:
        self._rendering = False
        self._published |= dict.fromkeys(names, revision)
        if isinstance(result, PPaaSError):
            self._report(f"the map is not published: {result}")
            return
        grid = GridMapMessage(result.grid, MAP, self._now()) if result.grid is not None else None
        messages: tuple[Payload | None, ...] = (
            self._octomap(result.binary, binary=True), self._octomap(result.full, binary=False), grid
        )  # fmt: skip
        for name, message in zip(MAPS, messages, strict=True):
            if message is not None:
                self.context.publish(name, message)
            if (message is None and name in names) or not self._parameters.latch:
                self.context.forget(name)

    def _octomap(self, data: bytes | None, *, binary: bool) -> OctomapFile | None:
        return None if data is None else OctomapFile(data, binary, self._parameters.resolution, self._now())

    def _now(self) -> Time:
        return Time.of(self.context.now())

    # -- services ------------------------------------------------------------------------------------------------------

    def _reply_map(self, reply: Reply, result: RenderedMaps | PPaaSError) -> None:
        if isinstance(result, PPaaSError):
            reply(result)
            return
        octomap = self._octomap(result.binary, binary=True) or self._octomap(result.full, binary=False)
        assert octomap is not None
        reply(GetOctomapResponse(octomap.to_message()))

    def _reply_file(self, reply: Reply, result: bytes | PPaaSError) -> None:
        if isinstance(result, PPaaSError):
            reply(result)
            return
        self._pages.use(result)
        reply(GetOctomapFileResponse(*self._pages.page(0)))

    def _reply_change(self, reply: Reply, result: Any) -> None:
        self._revision += 1
        reply(result if isinstance(result, PPaaSError) else Empty())
