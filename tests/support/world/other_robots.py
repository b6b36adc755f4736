"""Robots that are built otherwise than the simulated one: other frames, other mounts of the laser, other clocks."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.raycast import cast_rays
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.robot_model.shapes import placed
from ppaas.transforms.spatial import Rigid
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, walled_map

START, GOAL = Pose2D(1.0, 1.0, 0.0), Pose2D(4.5, 3.0, 0.0)


def link(parent: str, child: str, xyz=(0.0, 0.0, 0.0), rpy=(0.0, 0.0, 0.0)) -> TransformStamped:
    """Return a static transform."""
    return TransformStamped(Header(frame_id=parent), child, placed(xyz, rpy).to_message())


@dataclass
class OtherRobot(World):
    """A robot with named frames, and lasers on mounts of their own.

    ``names`` are the frames of its odometry and the one that it moves. ``lasers`` are the frames of its scans, which it
    sends in turn, with the pose of each on the robot. ``ahead`` is the time by which scans are stamped ahead [s].
    """

    names: tuple[str, str] = ("odom", "base_link")
    lasers: tuple[tuple[str, Rigid], ...] = (("base_scan", Rigid()),)
    ahead: float = 0.0
    turn: int = 0

    def odometry(self, stamp: float) -> Odometry:
        """Return the odometry with the robot's names."""
        message = super().odometry(stamp)
        message.header.frame_id, message.child_frame_id = self.names
        return message

    def scan(self, stamp: float) -> LaserScan:
        """Return the scan of the next laser."""
        frame, mount = self.lasers[self.turn % len(self.lasers)]
        self.turn += 1
        angles = np.linspace(-math.pi, math.pi, self.beams, endpoint=False)
        ranges = self._seen(mount, angles)
        return LaserScan(
            Header(stamp=Time.of(stamp + self.ahead), frame_id=frame),
            -math.pi, float(angles[-1]), 2.0 * math.pi / self.beams, 0.05, self.range_max,
            [r if math.isfinite(r) else None for r in ranges.tolist()],
        )  # fmt: skip

    def _seen(self, mount: Rigid, angles: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the ranges of a laser: to walls that rise for ever, or to the floor."""
        ends = np.array([(mount @ Rigid(math.cos(a), math.sin(a)))[:3] for a in angles.tolist()]) - mount[:3]
        flat = np.hypot(ends[:, 0], ends[:, 1])
        bearings = np.arctan2(ends[:, 1], ends[:, 0])
        at = Pose2D(*self.pose) @ Pose2D(mount.x, mount.y)
        walls = cast_rays(self.truth, self.grid.info, at, bearings, self.range_max) / flat
        with np.errstate(divide="ignore", invalid="ignore"):
            floor = np.where(ends[:, 2] < -1e-9, -mount.z / ends[:, 2], math.inf)
        ranges = np.minimum(walls, floor) + self.random.normal(0.0, self.noise, len(angles))
        return np.where(ranges < self.range_max, ranges, math.inf)


def robot(**options) -> OtherRobot:
    """Return a robot in a room with a box."""
    return OtherRobot(walled_map(6, 4, [(2.5, 0.0, 3.0, 2.0)]), START, **options)


def drive(world: World, *, static=(), seconds: float = 40.0, **clone) -> ClosedLoop:
    """Send a robot's static transforms, wait for its pose, and drive it to a goal."""
    driving = ClosedLoop(world, **clone)
    for message in static:
        driving.sense("tf_static", message)
    for _ in range(20):
        driving.step()
    driving.send_goal(GOAL)
    driving.run(seconds)
    return driving
