"""A short drive that nobody sees, before the first node is taken over: what is compiled then holds up no robot."""

import contextlib
import math
from collections.abc import Callable

from ppaas.clock import ManualClock
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovariance, Twist, TwistWithCovariance
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.std_msgs import Header, Time
from ppaas.nodes.graph import Graph

CYCLES = 30
PERIOD = 0.05
BEAMS = 360
EPOCH = 1e9


def warm_up(build: Callable[[Graph], None], initial_pose: Pose2D) -> None:
    """Let a clone drive for a moment, in a time of its own.

    Parameters
    ----------
    build : callable
        Adds all its nodes to a graph.
    initial_pose : Pose2D
        Where it stands.
    """
    clock = ManualClock()
    graph = Graph(clock=clock, stamp_clock=lambda: EPOCH + clock())
    build(graph)
    ahead = initial_pose @ Pose2D(0.5, 0.0, 0.0)
    for cycle in range(CYCLES):
        clock.advance(PERIOD)
        # Where it stands may be within a wall: then less is warmed up, which is no fault.
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
