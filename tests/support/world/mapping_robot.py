"""Robot that makes a map: the node ``grid_slam`` alone, which is fed the messages of a simulated drive."""

import math
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from benchmarks.mapping.simulated_drive import SimulatedDrive
from ppaas.clock import ManualClock
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.maps.occupancy import from_message
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.frames import FrameListener
from ppaas.nodes.graph import Graph
from ppaas.nodes.grid_slam.node import GridSlamNode
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.nodes.grid_slam.posegraph_services import NO_STORE, PoseGraphStore
from ppaas.nodes.grid_slam.publishing import MapSaver
from ppaas.nodes.jobs import Worker, run_inline
from ppaas.transforms.planar import transform_message
from tests.support.world.service_calls import call_service

START = 1000.0
"""Time of the first scan [s]."""


class HeldJobs:
    """Worker that runs jobs only when told to."""

    def __init__(self) -> None:
        self.held: list[tuple[Any, Any, Any]] = []

    def __call__(self, work: Any, cancelled: Any, done: Any) -> None:
        self.held.append((work, cancelled, done))

    def release(self) -> None:
        """Run the jobs that are held."""
        held, self.held = self.held, []
        for job in held:
            run_inline(*job)


class MappingRobot:
    """Robot of a simulated drive.

    Parameters
    ----------
    drive : SimulatedDrive
    worker : Worker
        Runs the jobs of the node.
    save : callable, optional
        Saves maps.
    prepare : callable, optional
        Run before the first scan.
    graphs : PoseGraphStore
        What pose graphs are saved to and loaded from.
    prepare_closures : callable, optional
        Run once scans are used.
    **parameters
        Parameters of ``grid_slam``.
    """

    def __init__(
        self,
        drive: SimulatedDrive,
        worker: Worker = run_inline,
        save: MapSaver | None = None,
        prepare: Callable[[], None] | None = None,
        graphs: PoseGraphStore = NO_STORE,
        prepare_closures: Callable[[], None] | None = None,
        **parameters: Any,
    ) -> None:
        self.drive, self.clock = drive, ManualClock(START)
        self.graph = Graph(worker, clock=self.clock, stamp_clock=self.clock)
        self.frames = FrameListener()
        self.heard: dict[str, list[Any]] = {}
        self.next = 0
        read = GridSlamParameters(**parameters)
        self.node = self.graph.add(
            lambda context: GridSlamNode(context, read, save, prepare, graphs=graphs, prepare_closures=prepare_closures)
        )
        self.graph.tap("tf", lambda topic, message: self.frames.hear(topic, message, self.clock()))
        for topic in ("map", "map_metadata", "map_updates", "pose", "entropy"):
            self.graph.tap(topic, self._hear)
        mount = transform_message("base_link", "laser", drive.log.geometry.mount, Time())
        self.graph.inject("tf_static", TFMessage([mount]))

    def _hear(self, topic: str, message: Any) -> None:
        whole = message.to_message() if hasattr(message, "to_message") else message
        self.heard.setdefault(topic, []).append(whole)

    def odom(self, pose: Pose2D, stamp: float | None = None) -> None:
        """Publish the pose of the robot in the odometry frame."""
        moment = Time.of(self.clock() if stamp is None else stamp)
        self.graph.inject("tf", TFMessage([transform_message("odom", "base_link", pose, moment)]))

    def scan_message(self, number: int, stamp: float | None = None) -> LaserScan:
        """Return a scan of the drive."""
        geometry = self.drive.log.geometry
        ranges = [None if math.isnan(value) else value for value in self.drive.log.ranges[number].tolist()]
        last = geometry.angle_min + geometry.angle_increment * (geometry.beams - 1)
        header = Header(stamp=Time.of(self.clock() if stamp is None else stamp), frame_id="laser")
        return LaserScan(header, geometry.angle_min, last, geometry.angle_increment, 0.05, 30.0, ranges)

    def odometry(self, number: int) -> Pose2D:
        """Return the odometry of a scan of the drive."""
        return Pose2D(*self.drive.log.odometry[number].tolist())

    def step(self, count: int = 1) -> None:
        """Send the odometry and the next scans, and run the timers that are due."""
        for number in range(self.next, self.next + count):
            self.clock.advance(START + float(self.drive.log.stamps[number]) - self.clock())
            self.odom(self.odometry(number))
            self.graph.inject("scan", self.scan_message(number))
            self.graph.run_due()
        self.next += count

    def poses(self) -> NDArray[np.float64]:
        """Return the poses published, (n, 3)."""
        return np.array([message.pose.pose.planar() for message in self.heard.get("pose", [])]).reshape(-1, 3)

    @property
    def in_map(self) -> Pose2D:
        """Pose of the robot by ``tf`` and its odometry at the last scan."""
        return self.frames.tree.lookup("map", "odom") @ self.odometry(self.next - 1)

    def true_error(self) -> float:
        """Return the distance of the pose by ``tf`` from the true one; the map frame is that of the first pose [m]."""
        first, last = (Pose2D(*self.drive.true[number].tolist()) for number in (0, self.next - 1))
        return self.in_map.distance_to(self.odometry(0) @ first.inverse() @ last)

    def call(self, service: str, request: Message | None = None) -> Any:
        """Call a service and return its reply; an error is raised."""
        return call_service(self.graph, service, Empty() if request is None else request)

    def map(self) -> GridMap:
        """Return the map by ``dynamic_map``."""
        return from_message(self.call("dynamic_map").map)

    def displayed(self) -> GridMap:
        """Return the map that a client has: the last whole one with the updates since."""
        whole = from_message(self.heard["map"][-1])
        cells = whole.data.copy()
        for update in self.heard.get("map_updates", []):
            if update.header.stamp.seconds() > self.heard["map"][-1].header.stamp.seconds():
                part = np.array(msgspec.json.decode(update.data), np.int8).reshape(update.height, update.width)
                cells[update.y : update.y + update.height, update.x : update.x + update.width] = part
        return GridMap(cells, whole.info)
