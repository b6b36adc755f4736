"""Node ``amcl``."""

import math

import pytest

from ppaas.clock import ManualClock
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.messages.geometry_msgs import Pose, PoseArray, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.messages.message import Empty
from ppaas.messages.std_msgs import Header, Time
from ppaas.nodes.amcl.node import AmclNode
from ppaas.nodes.frames import FrameListener
from ppaas.nodes.graph import Graph
from ppaas.nodes.tf.state_publisher import StatePublisherNode, StatePublisherParameters
from ppaas.robot_model.known_models import robot_model
from tests.support.world.planar_world import World, error_of, walled_map

GRID = walled_map(6, 5, [(3, 0, 3.2, 2), (4.5, 3.5, 5.5, 4)])
LAYERS = build_layers(GRID)
START = Pose2D(1.0, 1.0, 0.5)


class Home:
    """A graph with localization, and what it publishes."""

    def __init__(self, pose: Pose2D = START, initial: Pose2D | None = None, now: float = 100.0) -> None:
        self.world = World(GRID, pose)
        self.clock = ManualClock(now)
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        self.frames = FrameListener()
        self.poses: list[PoseWithCovarianceStamped] = []
        self.clouds: list[PoseArray] = []
        model, state = robot_model("turtlebot2"), StatePublisherParameters()
        self.graph.add(lambda context: StatePublisherNode(context, model, state))
        self.node = self.graph.add(lambda context: AmclNode(context, LAYERS, initial or pose, AmclParameters()))
        self.graph.tap("tf", lambda topic, message: self.frames.hear(topic, message, self.clock()))
        self.graph.tap("amcl_pose", lambda _, message: self.poses.append(message))
        self.graph.tap("particlecloud", lambda _, cloud: self.clouds.append(cloud.to_message()))

    def odom(self, stamp: float | None = None) -> None:
        self.graph.inject("odom", self.world.odometry(self.clock() if stamp is None else stamp))

    def scan(self, stamp: float | None = None) -> None:
        self.graph.inject("scan", self.world.scan(self.clock() if stamp is None else stamp))

    def told(self) -> Pose2D:
        return self.poses[-1].pose.pose.planar()

    def look(self) -> None:
        self.clock.advance(0.1)
        self.odom()
        self.scan()


def test_a_scan_tells_where_the_robot_is_and_where_odometry_lies_in_the_map():
    home = Home()
    home.look()
    home.look()
    assert error_of(home.told(), START)[0] < 0.1
    assert error_of(home.frames.tree.lookup("map", "base_link"), home.told())[0] < 1e-6
    assert home.poses[-1].header.frame_id == "map"
    assert home.poses[-1].header.stamp.seconds() == pytest.approx(100.2)
    assert len(home.clouds[0].poses) >= 500


def test_the_transform_is_stamped_into_the_future_by_the_tolerance():
    home = Home()
    home.look()
    assert home.frames.tree.newest("odom") == pytest.approx(100.2)


def test_a_robot_that_stands_is_told_of_with_every_scan_but_its_particles_are_left_alone():
    home = Home()
    for _ in range(5):
        home.look()
    assert len(home.poses) == 5
    assert len(home.clouds) == 1
    assert home.frames.tree.newest("odom") == pytest.approx(100.6)


def test_a_scan_waits_for_the_odometry_of_its_time():
    home = Home()
    home.odom(100.0)
    home.scan(100.05)
    assert not home.poses
    home.odom(100.1)
    assert len(home.poses) == 1
    assert home.poses[0].header.stamp.seconds() == pytest.approx(100.05)


@pytest.mark.parametrize("stamp", [Time(1_764_000_000, 123_450_499), Time(1_764_000_000, 7)])
def test_a_pose_has_the_very_stamp_of_its_scan(stamp: Time):
    home = Home()
    home.odom(1_764_000_000.0)
    scan = home.world.scan(0.0)
    scan.header.stamp = stamp
    home.graph.inject("scan", scan)
    home.odom(1_764_000_000.2)
    assert home.poses[-1].header.stamp == stamp


def test_a_scan_without_a_stamp_goes_with_the_latest_odometry():
    home = Home()
    home.odom(100.0)
    home.scan(0.0)
    assert home.poses[-1].header.stamp.seconds() == pytest.approx(100.0)


def test_a_scan_in_an_unknown_frame_is_refused_to_its_sender():
    home = Home()
    home.odom()
    scan = home.world.scan(100.0)
    scan.header.frame_id = "velodyne"
    with pytest.raises(TransformError, match="velodyne"):
        home.graph.inject("scan", scan)


def test_a_scan_that_is_older_than_all_odometry_is_refused():
    home = Home()
    home.odom(100.0)
    with pytest.raises(TransformError, match=r"80\.000"):
        home.scan(80.0)


@pytest.mark.parametrize(("late", "taken"), [(0.9, True), (1.1, False)])
def test_a_scan_that_comes_long_after_it_was_taken_is_refused(late, taken):
    home = Home()
    for _ in range(30):
        home.clock.advance(0.1)
        home.odom()
    if taken:
        home.scan(home.clock() - late)
        assert home.poses
        return
    with pytest.raises(InvalidInput, match=r"1\.1 s before the newest odometry"):
        home.scan(home.clock() - late)
    assert not home.poses


def test_the_covariance_has_its_numbers_where_ros_has_them():
    home = Home()
    home.look()
    covariance = home.poses[-1].pose.covariance
    assert len(covariance) == 36
    assert {i for i, value in enumerate(covariance) if value != 0.0} <= {0, 1, 5, 6, 7, 11, 30, 31, 35}
    assert covariance[0] > 0.0 < covariance[35]


def initial_pose(pose: Pose2D, frame: str = "map", covariance: list[float] | None = None) -> PoseWithCovarianceStamped:
    spread = [0.0] * 36
    spread[0] = spread[7] = spread[35] = 0.01
    stamped = PoseWithCovariance(Pose.of(pose), spread if covariance is None else covariance)
    return PoseWithCovarianceStamped(Header(stamp=Time(), frame_id=frame), stamped)


def test_an_initial_pose_begins_anew_from_there():
    home = Home(initial=Pose2D(5.0, 4.5, 3.0))
    home.look()
    home.graph.inject("initialpose", initial_pose(START))
    home.look()
    assert error_of(home.told(), START)[0] < 0.1


@pytest.mark.parametrize(
    ("message", "error"),
    [
        (initial_pose(Pose2D(math.nan, 0, 0)), InvalidInput),
        (initial_pose(START, covariance=[0.0] * 9), InvalidInput),
        (initial_pose(START, covariance=[math.inf] * 36), InvalidInput),
        (initial_pose(START, frame="odom"), TransformError),
    ],
)
def test_an_initial_pose_that_cannot_be_taken_is_refused_and_disturbs_nothing(message, error):
    home = Home()
    home.look()
    with pytest.raises(error):
        home.graph.inject("initialpose", message)
    home.look()
    assert error_of(home.told(), START)[0] < 0.1


def test_a_checkpoint_goes_on_from_where_odometry_has_come_meanwhile():
    first = Home()
    first.look()
    (checkpoint,) = first.graph.checkpoints()
    second = Home(initial=Pose2D(4.0, 1.0, 0.0), now=103.0)
    second.world = first.world
    second.world.move(0.4, 0.0, 2.0)
    second.graph.restore([checkpoint])
    second.look()
    assert error_of(second.told(), second.world.pose)[0] < 0.1


def test_a_checkpoint_of_a_robot_whose_odometry_was_reset_goes_on_from_its_place():
    first = Home()
    first.world.odom = Pose2D(50.0, 20.0, 1.0)
    first.look()
    (checkpoint,) = first.graph.checkpoints()
    second = Home(initial=Pose2D(4.0, 1.0, 0.0), now=103.0)
    second.world = first.world
    second.world.odom = Pose2D(0.0, 0.0, 0.0)
    second.graph.restore([checkpoint])
    second.look()
    assert error_of(second.told(), START)[0] < 0.1


def test_a_checkpoint_before_any_scan_after_a_restore_is_the_one_restored():
    first = Home()
    first.look()
    (checkpoint,) = first.graph.checkpoints()
    second = Home(initial=Pose2D(4.0, 1.0, 0.0))
    second.graph.restore([checkpoint])
    assert second.graph.checkpoints() == [checkpoint]


def call(home: Home, service: str) -> list[object]:
    answers: list[object] = []
    home.graph.call(service, Empty(), answers.append)
    return answers


def test_a_robot_that_nobody_knows_where_it_is_is_found_all_over_the_map():
    home = Home(initial=Pose2D(5.2, 1.0, 3.0))
    home.look()
    assert error_of(home.told(), START)[0] > 1.0
    assert call(home, "global_localization") == [Empty()]
    for _ in range(20):
        home.world.move(0.5, 0.3, 0.3)
        home.look()
    assert error_of(home.told(), home.world.pose)[0] < 0.15


def test_a_robot_that_is_looked_for_is_looked_for_by_the_clone_that_goes_on_as_well():
    first = Home(initial=Pose2D(5.2, 1.0, 3.0))
    call(first, "global_localization")
    (checkpoint,) = first.graph.checkpoints()
    second = Home(initial=Pose2D(5.2, 1.0, 3.0))
    second.graph.restore([checkpoint])
    for _ in range(20):
        second.world.move(0.5, 0.3, 0.3)
        second.look()
    assert error_of(second.told(), second.world.pose)[0] < 0.15


def test_an_update_that_is_asked_for_comes_with_the_next_scan_and_once():
    home = Home()
    home.look()
    assert call(home, "request_nomotion_update") == [Empty()]
    home.look()
    home.look()
    assert len(home.clouds) == 2


def test_a_base_that_begins_anew_leaves_its_robot_where_it_was():
    home = Home()
    home.world.odom = Pose2D(40.0, 20.0, 1.0)
    home.look()
    home.world.move(0.06, 0.0, 1.0)  # not far enough for an update
    home.look()
    home.world.odom = Pose2D(0.0, 0.0, 0.0)
    home.look()
    home.world.move(0.5, 0.0, 1.0)
    home.look()
    assert error_of(home.told(), home.world.pose)[0] < 0.1


def test_a_scan_older_than_the_last_one_is_refused_by_how_much():
    home = Home()
    home.odom(100.0)
    home.odom(101.0)
    home.scan(101.0)
    with pytest.raises(InvalidInput, match=r"0\.500 s before"):
        home.scan(100.5)


def test_a_clock_that_was_set_back_is_gone_on_from():
    home = Home()
    home.look()
    home.clock.now = 50.0
    home.look()
    assert home.poses[-1].header.stamp.seconds() == pytest.approx(50.1)


@pytest.mark.parametrize("change", [lambda s: s.ranges.extend([1.0] * 4), lambda s: s.ranges.clear()])
def test_a_scan_with_another_number_of_ranges_than_its_angles_are_for_is_refused(change):
    home = Home()
    home.odom()
    scan = home.world.scan(100.0)
    change(scan)
    with pytest.raises(InvalidInput, match="ranges, not"):
        home.graph.inject("scan", scan)


def test_a_scan_of_which_every_second_range_is_nan_or_infinite_still_does():
    home = Home()
    home.odom()
    scan = home.world.scan(100.0)
    scan.ranges[::4] = [math.nan] * len(scan.ranges[::4])
    scan.ranges[2::4] = [math.inf] * len(scan.ranges[2::4])
    home.graph.inject("scan", scan)
    assert error_of(home.told(), START)[0] < 0.1


def test_an_initial_pose_outside_of_the_map_is_refused_by_where_the_map_lies():
    home = Home()
    with pytest.raises(InvalidInput, match=r"\(7, 1\) is outside the map, which covers 6 × 5 m from \(0, 0\)"):
        home.graph.inject("initialpose", initial_pose(Pose2D(7.0, 1.0)))
