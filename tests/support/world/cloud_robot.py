"""Robot with a 3D sensor: the node ``octomap_server`` alone, which is fed transforms, clouds and key frames."""

import math
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.clock import ManualClock
from ppaas.geometry import Pose2D
from ppaas.mapping.volume.key_frame_poses import KeyFramePoses
from ppaas.maps.octomap import BINARY, parse_octomap
from ppaas.maps.octree import OcTree
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from ppaas.messages.octomap_msgs import Octomap
from ppaas.messages.sensor_msgs import PointCloud2, PointField, PointFieldType
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.graph import Graph
from ppaas.nodes.jobs import Worker, run_inline
from ppaas.nodes.key_frame_path import KeyFramePath
from ppaas.nodes.octomap_server.node import OctomapServerNode
from ppaas.nodes.octomap_server.parameters import OctomapServerParameters, spelled
from ppaas.parameters import read_parameters
from ppaas.transforms.planar import transform_message
from tests.support.world.service_calls import call_service

START = 100.0
"""Time at the start [s]."""

HEIGHT = 0.55
"""Height of the sensor above the floor [m]."""

AXES = ("x", "y", "z")


def cloud_message(points: NDArray[np.float32], stamp: float, frame: str = "lidar") -> PointCloud2:
    """Return points (n, 3) in the frame of the sensor as a message with 16 bytes per point."""
    padded = np.zeros((len(points), 4), "<f4")
    padded[:, :3] = points
    fields = [PointField(axis, 4 * index, PointFieldType.FLOAT32, 1) for index, axis in enumerate(AXES)]
    header, count = Header(stamp=Time.of(stamp), frame_id=frame), len(points)
    return PointCloud2(header, 1, count, fields, False, 16, 16 * count, padded.tobytes(), True)


def wall(distance: float) -> NDArray[np.float32]:
    """Return points of a wall ahead of the sensor, (n, 3) [m]."""
    across, up = np.meshgrid(np.linspace(-1.0, 1.0, 41), np.linspace(-0.4, 0.4, 17))
    return np.stack([np.full(across.size, distance), across.ravel(), up.ravel()], axis=1).astype(np.float32)


class CloudRobot:
    """Robot whose sensor looks ahead.

    Parameters
    ----------
    worker : Worker
        Runs the jobs of the node.
    **parameters
        Parameters of ``octomap_server``.
    """

    def __init__(self, worker: Worker = run_inline, **parameters: Any) -> None:
        self.clock = ManualClock(START)
        self.graph = Graph(worker, clock=self.clock, stamp_clock=self.clock)
        read = read_parameters(OctomapServerParameters, "octomap_server", spelled({"resolution": 0.1} | parameters))
        self.node = self.graph.add(lambda context: OctomapServerNode(context, read))
        self.heard: dict[str, list[Any]] = {}
        self.graph.tap("octomap_server/status", self._hear)
        turn = math.sqrt(0.5)
        self._mount("base_link", "base_footprint", Vector3(0.0, 0.0, -0.1), Quaternion(z=0.0, w=1.0))
        self._mount("base_link", "lidar", Vector3(0.0, 0.0, HEIGHT - 0.1), Quaternion(z=0.0, w=1.0))
        # The optical frame of a camera: x to the right, y down, z ahead.
        self._mount("lidar", "camera", Vector3(), Quaternion(x=-0.5, y=0.5, z=-0.5, w=0.5))
        self._mount("lidar", "left", Vector3(), Quaternion(z=turn, w=turn))

    def _mount(self, parent: str, child: str, where: Vector3, rotation: Quaternion) -> None:
        self.graph.inject(
            "tf_static", TFMessage([TransformStamped(Header(frame_id=parent), child, Transform(where, rotation))])
        )

    def _hear(self, topic: str, message: Any) -> None:
        self.heard.setdefault(topic, []).append(message.to_message() if hasattr(message, "to_message") else message)

    def hear(self, topic: str) -> None:
        """Subscribe to a topic."""
        self.graph.tap(topic, self._hear)

    @property
    def status(self) -> str:
        """Last status of the node."""
        return str(self.heard.get("octomap_server/status", [_NO_STATUS])[-1].data)

    def move(self, pose: Pose2D, *, correction: Pose2D | None = Pose2D(0.0, 0.0)) -> None:
        """Publish the pose in the odometry frame now, and that frame in the map frame, unless it is None."""
        stamp = Time.of(self.clock())
        transforms = [transform_message("odom", "base_link", pose, stamp)]
        if correction is not None:
            transforms.append(transform_message("map", "odom", correction, stamp))
        self.graph.inject("tf", TFMessage(transforms))

    def key_frames(self, *frames: tuple[float, Pose2D]) -> None:
        """Publish key frames: times [s] and poses in the map frame."""
        stamps = np.array([stamp for stamp, _ in frames])
        poses = np.array([pose for _, pose in frames]).reshape(-1, 3)
        self.graph.inject("key_frames", KeyFramePath(KeyFramePoses(stamps, poses), Time()).to_message())

    def send(self, points: NDArray[np.float32], frame: str = "lidar", stamp: float | None = None) -> None:
        """Send a cloud, by default of now."""
        self.graph.inject("cloud_in", cloud_message(points, self.clock() if stamp is None else stamp, frame))

    def call(self, service: str, request: Message | None = None) -> Any:
        """Call a service and return its reply; an error is raised."""
        return call_service(self.graph, service, Empty() if request is None else request)

    def tree(self) -> OcTree:
        """Return the octree by ``octomap_binary``."""
        return tree_of(self.call("octomap_binary").map)

    def occupied(self) -> NDArray[np.float64]:
        """Return the centres of the occupied voxels, (n, 3) [m]; no eight of them may be merged."""
        tree = self.tree()
        return (tree.corners[tree.occupied].astype(float) - 32768 + 0.5) * tree.resolution


def tree_of(message: Octomap) -> OcTree:
    """Return the octree of a message, as a client reads it."""
    assert isinstance(message.data, msgspec.Raw)
    nodes = np.array(msgspec.json.decode(message.data), np.int8).tobytes()
    count = _nodes_in(nodes, binary=message.binary)
    first = BINARY if message.binary else b"# Octomap OcTree file"
    header = b"%b\nid OcTree\nsize %d\nres %f\ndata\n" % (first, count, message.resolution)
    return parse_octomap(header + nodes)


def _nodes_in(nodes: bytes, *, binary: bool) -> int:
    """Return the number of nodes: two bits each in a binary file, 11 for an inner node; else five bytes each."""
    if not binary:
        return len(nodes) // 5
    pairs = np.frombuffer(nodes, np.uint8)[:, None] >> np.arange(0, 8, 2) & 3
    return int((pairs != 0).sum()) + min(1, len(nodes))


class _Status:
    data = ""


_NO_STATUS = _Status()
