"""Node ``leg_detector`` in a graph: scans wait for odometry, and measurements are in the robot's frame."""

import math

import pytest

from ppaas.clock import ManualClock
from ppaas.clone.assembly import build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED, GridMap
from ppaas.messages import decode, encode
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.people_coordination import SensorView
from ppaas.messages.people_msgs import PositionMeasurementArray
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.graph import Graph
from ppaas.nodes.leg_detector.node import MOST_LASERS, LegDetectorNode
from ppaas.nodes.topics import LEG_MEASUREMENTS, LEG_VIEW, ROBOTS, SCAN, TF, TF_STATIC
from ppaas.perception.legs.parameters import LegDetectorParameters
from ppaas.transforms.planar import transform_message
from tests.support.world.legs import GRID, LAYERS, scan_of, stand
from tests.support.world.planar_world import walled_map

ODOM = Pose2D(2.0, 1.0, 0.3)


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(100.0)


@pytest.fixture
def graph(clock: ManualClock) -> Graph:
    made = Graph(clock=clock, stamp_clock=clock)
    made.add(lambda context: LegDetectorNode(context, LegDetectorParameters(), LAYERS))
    return made


def moved(graph: Graph, stamp: float, robot: Pose2D = ODOM, in_map: Pose2D | None = None) -> None:
    """Publish odometry, and the pose of the robot in the map if it is localized."""
    transforms = [transform_message("odom", "base_link", robot, Time.of(stamp))]
    if in_map is not None:
        transforms.append(transform_message("map", "odom", in_map @ robot.inverse(), Time.of(stamp + 0.1)))
    graph.inject(TF.name, TFMessage(transforms))


def measured(graph: Graph) -> list[PositionMeasurementArray]:
    received: list[PositionMeasurementArray] = []
    graph.tap(LEG_MEASUREMENTS.name, lambda _, message: received.append(message))
    return received


def test_person_is_measured_in_the_frame_of_the_robot_once_odometry_reaches_the_scan(graph):
    robot, received = Pose2D(6.0, 5.0, 1.0), measured(graph)
    person = robot @ Pose2D(2.0, 0.5)
    moved(graph, 99.9)
    graph.inject(SCAN.name, scan_of(robot, 100.0, stand(person.x, person.y, facing=2.0)))
    assert received == []
    moved(graph, 100.1, in_map=robot)
    [measurement] = received
    assert (measurement.header.frame_id, measurement.header.stamp) == ("base_link", Time.of(100.0))
    [found] = [each for each in measurement.people if each.initialization]
    assert math.hypot(found.pos.x - 2.0, found.pos.y - 0.5) < 0.1
    assert 0.7 < found.reliability <= 1.0
    assert 0.0 < found.covariance[0] == found.covariance[4] < 0.02


def test_other_robots_on_the_map_are_no_people(graph):
    robot, received = Pose2D(6.0, 5.0, 1.0), measured(graph)
    legs = stand(7.0, 6.0, facing=0.8)
    moved(graph, 99.9)
    for told in (False, True):
        if told:
            header, pose = Header(stamp=Time.of(100.0), frame_id="map"), Pose.of(Pose2D(7.0, 6.0))
            graph.inject(ROBOTS.name, RobotStates(header, [pose], [], []))
        graph.inject(SCAN.name, scan_of(robot, 100.0 + told, legs))
        moved(graph, 100.1 + told, in_map=robot)
    assert [any(each.initialization for each in message.people) for message in received] == [True, False]


def test_view_of_the_laser_is_told_once(graph):
    views: list[SensorView] = []
    graph.tap(LEG_VIEW.name, lambda _, message: views.append(message))
    for stamp in (100.0, 100.1):
        graph.inject(SCAN.name, scan_of(Pose2D(6.0, 5.0), stamp))
    [view] = views
    assert view.field_of_view == pytest.approx(2.0 * math.pi)
    assert (view.x, view.y, view.range_min) == (0.0, 0.0, 0.2)
    assert view.range_max == pytest.approx(4.0, abs=0.1), "with beams 1° apart; detections go on until 5 m"


def test_scans_that_cannot_be_used_are_refused(graph):
    scan = scan_of(Pose2D(6.0, 5.0), 100.0)
    with pytest.raises(InvalidInput, match="finite"):
        graph.inject(SCAN.name, LaserScan(scan.header, math.nan, 1.0, 0.1, 0.1, 8.0, [1.0]))
    scan.header.frame_id = "unknown"
    with pytest.raises(TransformError, match="unknown"):
        graph.inject(SCAN.name, scan)


def test_clone_has_the_detector_if_its_robot_has_parameters_for_it(clock):
    for parameters in ({}, {"leg_detector": {"max_range": 4.0}}):
        graph = Graph(clock=clock)
        layers = build_layers(walled_map(4, 3, []))
        build_clone(graph, layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters=parameters)
        assert ("leg_detector" in graph.nodes) is bool(parameters)


def test_map_that_replaces_another_is_used_for_the_next_scan(graph):
    robot, received = Pose2D(6.0, 5.0, 1.0), measured(graph)
    legs = stand(7.0, 6.0, facing=0.8)
    walled = GRID.data.copy()
    walled[tuple(slice(*(round(20.0 * (x + side)) for side in (-0.5, 0.5))) for x in (6.0, 7.0))] = OCCUPIED
    moved(graph, 99.9)
    for stamp in (100.0, 101.0):
        graph.inject(SCAN.name, scan_of(robot, stamp, legs))
        moved(graph, stamp + 0.1, in_map=robot)
        graph.nodes["leg_detector"].use_layers(build_layers(GridMap(walled, GRID.info)))
    assert [len(message.people) > 0 for message in received] == [True, False]


def test_number_of_lasers_is_limited(graph):
    received = measured(graph)
    moved(graph, 99.9)
    scan = scan_of(Pose2D(6.0, 5.0), 100.0)
    mounts = [transform_message("base_link", f"laser_{k}", Pose2D(0.0, 0.0), Time()) for k in range(MOST_LASERS + 2)]
    graph.inject(TF_STATIC.name, TFMessage(mounts))
    for mount in mounts:
        scan.header.frame_id = mount.child_frame_id
        graph.inject(SCAN.name, decode(LaserScan, encode(scan)))
    moved(graph, 100.1)
    assert len(received) == MOST_LASERS
