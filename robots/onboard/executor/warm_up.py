"""Warm-up of the executor: a short simulated drive before the first node is taken over, which compiles all kernels."""

import contextlib
import math
from collections.abc import Callable

from ppaas.clock import ManualClock
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovariance, Twist, TwistWithCovariance
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.graph import Graph

CYCLES = 30
"""Number of sensor cycles."""
PERIOD = 0.05
"""Simulated time of a cycle [s]."""
BEAMS = 360
"""Number of beams of the simulated scan."""
EPOCH = 1e9
"""Stamp of the start [seconds since the epoch]."""


def warm_up(build: Callable[[Graph], None], initial_pose: Pose2D) -> None:
    """Drive a clone for a moment in simulated time.

    Parameters
    ----------
    build : callable
        Adds all nodes of the clone to a graph.
    initial_pose : Pose2D
        Pose of the robot in the frame ``map``.
    """
    clock = ManualClock()
    graph = Graph(clock=clock, stamp_clock=lambda: EPOCH + clock())
    build(graph)
    ahead = initial_pose @ Pose2D(0.5, 0.0, 0.0)
    for cycle in range(CYCLES):
        clock.advance(PERIOD)
        # The pose may be inside an obstacle: the warm-up then covers less, which is not an error.
        with contextlib.suppress(PPaaSError):
            _sense(graph, 0.02 * cycle)
            if cycle == CYCLES // 3:
                graph.inject("move_base_simple/goal", PoseStamped(Header(frame_id="map"), Pose.of(ahead)))
            graph.run_due()


def _sense(graph: Graph, travelled: float) -> None:
    stamp = Time.of(graph.now())
    pose = PoseWithCovariance(Pose.of(Pose2D(travelled, 0.0)))
    odometry = Odometry(Header(stamp=stamp, frame_id="odom"), "base_link", pose, TwistWithCovariance(Twist()))
    graph.inject("odom", odometry)
    scan = LaserScan(
        Header(stamp=stamp, frame_id="base_link"),
        angle_min=-math.pi,
        angle_max=math.pi,
        angle_increment=2.0 * math.pi / BEAMS,
        range_min=0.1,
        range_max=8.0,
        ranges=[2.0] * BEAMS,
    )
    graph.inject("scan", scan)
