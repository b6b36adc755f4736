"""Node that takes the outline of what the robot carries."""

import math

import pytest

from ppaas.errors import InvalidInput
from ppaas.footprints import MAX_CORNERS, Footprint
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point32, Polygon
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node
from ppaas.nodes.footprint.node import FootprintNode, load_in
from ppaas.nodes.graph import Graph
from ppaas.transforms.planar import transform_message

SQUARE = ((0.4, 0.4), (-0.4, 0.4), (-0.4, -0.4), (0.4, -0.4))
RANGES = [0.3, 0.5, 2.0, 0.3]
"""Of beams ahead, to the left, to the back and to the right."""


class ScanListener(Node):
    """Any node that uses scans."""

    name = "listener"
    subscribes = (topics.SCAN,)


class Robot:
    """The node in a graph, with what it said."""

    def __init__(self, load: Footprint = ()) -> None:
        self.graph, self.loads = Graph(), list[Footprint]()
        self.graph.add(ScanListener)
        self.graph.add(lambda context: self._made(context, load))
        self.seen: list[float | None] = []
        self.graph.tap("scan", lambda _, scan: self.seen.extend(scan.ranges))  # type: ignore[union-attr]

    def _made(self, context: Context, load: Footprint) -> FootprintNode:
        self.node = FootprintNode(context, self.graph, self.loads.append, load)
        return self.node

    def scan(self, frame: str = "base_link") -> list[bool]:
        """Send a scan; return which of its beams have a reading."""
        self.seen.clear()
        turn = 0.5 * math.pi
        scan = LaserScan(Header(frame_id=frame), 0.0, 3.0 * turn, turn, 0.05, 8.0, list(RANGES))
        self.graph.inject("scan", scan)
        return [each is not None and math.isfinite(each) for each in self.seen]

    def carry(self, *corners: tuple[float, float], topic: str = "local_costmap/footprint") -> None:
        """Publish an outline."""
        self.graph.inject(topic, Polygon([Point32(x, y) for x, y in corners]))


def test_the_load_is_not_in_the_scans() -> None:
    robot = Robot()
    assert robot.scan() == [True] * 4
    robot.carry(*SQUARE)
    assert robot.scan() == [False, True, True, False]
    robot.carry()
    assert robot.scan() == [True] * 4
    assert robot.loads == [SQUARE, ()]


def test_the_place_of_the_laser_counts() -> None:
    robot = Robot(SQUARE)
    mount = transform_message("base_link", "laser", Pose2D(-0.3, 0.0, 0.0), Time())
    robot.graph.inject("tf_static", TFMessage([mount]))
    assert robot.scan("laser") == [False, True, True, False]
    ahead = transform_message("base_link", "laser", Pose2D(0.3, 0.0, 0.0), Time())
    robot.graph.inject("tf_static", TFMessage([ahead]))
    assert robot.scan("laser") == [True, True, True, False]
    assert robot.scan("unknown") == [True] * 4, "nodes refuse it themselves"


def test_both_costmaps_have_one_outline() -> None:
    robot = Robot()
    for topic in ("local_costmap/footprint", "global_costmap/footprint"):
        robot.carry(*SQUARE, topic=topic)
    assert robot.loads == [SQUARE]


@pytest.mark.parametrize(
    "corners",
    [[(0.1, 0.1), (0.2, 0.2)], [(math.nan, 0.0), *SQUARE], [(50.0, 0.0), *SQUARE], [(0, 0)] * (MAX_CORNERS + 1)],
)
def test_outlines_that_are_none_are_refused(corners: list[tuple[float, float]]) -> None:
    robot = Robot(SQUARE)
    with pytest.raises(InvalidInput, match="outline"):
        robot.carry(*corners)
    assert robot.loads == []


def test_a_load_is_carried_on_in_another_executor() -> None:
    before, robot = Robot(SQUARE), Robot()
    state = before.node.checkpoint()
    assert load_in(state) == SQUARE and load_in(None) == ()
    robot.node.restore(state)
    assert robot.loads == [SQUARE] and robot.scan() == [False, True, True, False]
    robot.node.restore(state)
    assert robot.loads == [SQUARE]
