"""Node ``amcl``."""

import math

import pytest

from ppaas.clock import ManualClock
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import Header, String, Time
from ppaas.messages.geometry_msgs import (
    Pose,
    PoseArray,
    PoseWithCovariance,
    PoseWithCovarianceStamped,
    Quaternion,
    Transform,
    TransformStamped,
    Vector3,
)
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.amcl.continuity import LONGEST_GAP
from ppaas.nodes.amcl.node import AmclNode
from ppaas.nodes.frames import FrameListener
from ppaas.nodes.graph import Checkpoint, Graph
from ppaas.nodes.tf.state_publisher import StatePublisherNode, StatePublisherParameters
from ppaas.robot_model.known_models import robot_model
from ppaas.transforms.planar import transform_message
from tests.support.world.planar_world import World, error_of, walled_map

GRID = walled_map(6, 5, [(3, 0, 3.2, 2), (4.5, 3.5, 5.5, 4)])
LAYERS = build_layers(GRID)
START = Pose2D(1.0, 1.0, 0.5)


class AmclUnderTest:
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

    def status(self) -> str:
        """Return why localization uses no scans."""
        latched = self.graph.latched("amcl/status")
        return latched.data if isinstance(latched, String) else ""

    def estimate(self) -> Pose2D:
        return self.poses[-1].pose.pose.planar()

    def step(self) -> None:
        self.clock.advance(0.1)
        self.odom()
        self.scan()


def test_scan_publishes_pose_and_transform():
    amcl = AmclUnderTest()
    amcl.step()
    amcl.step()
    assert error_of(amcl.estimate(), START)[0] < 0.1
    assert error_of(amcl.frames.tree.lookup("map", "base_link"), amcl.estimate())[0] < 1e-6
    assert amcl.poses[-1].header.frame_id == "map"
    assert amcl.poses[-1].header.stamp.seconds() == pytest.approx(100.2)
    assert len(amcl.clouds[0].poses) >= 500


def test_transform_is_stamped_ahead_by_the_tolerance():
    amcl = AmclUnderTest()
    amcl.step()
    assert amcl.frames.tree.newest("odom") == pytest.approx(100.2)


def test_robot_at_rest_is_published_without_particle_updates():
    amcl = AmclUnderTest()
    for _ in range(5):
        amcl.step()
    assert len(amcl.poses) == 5
    assert len(amcl.clouds) == 1
    assert amcl.frames.tree.newest("odom") == pytest.approx(100.6)


def test_scan_waits_for_odometry_of_its_time():
    amcl = AmclUnderTest()
    amcl.odom(100.0)
    amcl.scan(100.05)
    assert not amcl.poses
    amcl.odom(100.1)
    assert len(amcl.poses) == 1
    assert amcl.poses[0].header.stamp.seconds() == pytest.approx(100.05)


@pytest.mark.parametrize("stamp", [Time(1_764_000_000, 123_450_499), Time(1_764_000_000, 7)])
def test_pose_has_the_exact_stamp_of_its_scan(stamp: Time):
    amcl = AmclUnderTest()
    amcl.odom(1_764_000_000.0)
    scan = amcl.world.scan(0.0)
    scan.header.stamp = stamp
    amcl.graph.inject("scan", scan)
    amcl.odom(1_764_000_000.2)
    assert amcl.poses[-1].header.stamp == stamp


def test_scan_without_a_stamp_uses_the_latest_odometry():
    amcl = AmclUnderTest()
    amcl.odom(100.0)
    amcl.scan(0.0)
    assert amcl.poses[-1].header.stamp.seconds() == pytest.approx(100.0)


def test_scan_in_an_unknown_frame_is_refused():
    amcl = AmclUnderTest()
    amcl.odom()
    scan = amcl.world.scan(100.0)
    scan.header.frame_id = "velodyne"
    with pytest.raises(TransformError, match="velodyne"):
        amcl.graph.inject("scan", scan)


def test_scan_older_than_all_odometry_is_refused():
    amcl = AmclUnderTest()
    amcl.odom(100.0)
    with pytest.raises(InvalidInput, match=r"20\.0 s before the newest odometry"):
        amcl.scan(80.0)


@pytest.mark.parametrize(("late", "taken"), [(0.9, True), (1.1, False)])
def test_late_scan_is_refused(late, taken):
    amcl = AmclUnderTest()
    for _ in range(30):
        amcl.clock.advance(0.1)
        amcl.odom()
    if taken:
        amcl.scan(amcl.clock() - late)
        assert amcl.poses
        return
    with pytest.raises(InvalidInput, match=r"1\.1 s before the newest odometry"):
        amcl.scan(amcl.clock() - late)
    assert not amcl.poses


def test_covariance_is_laid_out_like_in_ros():
    amcl = AmclUnderTest()
    amcl.step()
    covariance = amcl.poses[-1].pose.covariance
    assert len(covariance) == 36
    assert {i for i, value in enumerate(covariance) if value != 0.0} <= {0, 1, 5, 6, 7, 11, 30, 31, 35}
    assert covariance[0] > 0.0 < covariance[35]


def initial_pose(pose: Pose2D, frame: str = "map", covariance: list[float] | None = None) -> PoseWithCovarianceStamped:
    spread = [0.0] * 36
    spread[0] = spread[7] = spread[35] = 0.01
    stamped = PoseWithCovariance(Pose.of(pose), spread if covariance is None else covariance)
    return PoseWithCovarianceStamped(Header(stamp=Time(), frame_id=frame), stamped)


def test_initial_pose_restarts_localization():
    amcl = AmclUnderTest(initial=Pose2D(5.0, 4.5, 3.0))
    amcl.step()
    amcl.graph.inject("initialpose", initial_pose(START))
    amcl.step()
    assert error_of(amcl.estimate(), START)[0] < 0.1


@pytest.mark.parametrize(
    ("message", "error"),
    [
        (initial_pose(Pose2D(math.nan, 0, 0)), InvalidInput),
        (initial_pose(START, covariance=[0.0] * 9), InvalidInput),
        (initial_pose(START, covariance=[math.inf] * 36), InvalidInput),
        (initial_pose(START, frame="odom"), TransformError),
    ],
)
def test_invalid_initial_pose_is_refused_and_changes_nothing(message, error):
    amcl = AmclUnderTest()
    amcl.step()
    with pytest.raises(error):
        amcl.graph.inject("initialpose", message)
    amcl.step()
    assert error_of(amcl.estimate(), START)[0] < 0.1


def test_restored_checkpoint_accounts_for_odometry_in_between():
    first = AmclUnderTest()
    first.step()
    (checkpoint,) = first.graph.checkpoints()
    second = AmclUnderTest(initial=Pose2D(4.0, 1.0, 0.0), now=103.0)
    second.world = first.world
    second.world.move(0.4, 0.0, 2.0)
    second.graph.restore([checkpoint])
    second.step()
    assert error_of(second.estimate(), second.world.pose)[0] < 0.1


def test_a_robot_that_drove_far_since_an_old_checkpoint_is_where_odometry_has_brought_it():
    first = AmclUnderTest(Pose2D(0.6, 0.6, 0.46))
    first.step()
    (checkpoint,) = first.graph.checkpoints()
    driven = Pose2D(LONGEST_GAP + 0.3, 0.0, 0.2)
    second = AmclUnderTest(initial=Pose2D(4.0, 1.0, 0.0), now=112.0)
    second.world = first.world
    second.world.pose, second.world.odom = second.world.pose @ driven, second.world.odom @ driven
    second.graph.restore([checkpoint])
    second.step()
    assert error_of(second.estimate(), second.world.pose)[0] < 0.1


def test_restored_checkpoint_tolerates_an_odometry_reset():
    first = AmclUnderTest()
    first.world.odom = Pose2D(50.0, 20.0, 1.0)
    first.step()
    (checkpoint,) = first.graph.checkpoints()
    second = AmclUnderTest(initial=Pose2D(4.0, 1.0, 0.0), now=103.0)
    second.world = first.world
    second.world.odom = Pose2D(0.0, 0.0, 0.0)
    second.graph.restore([checkpoint])
    second.step()
    assert error_of(second.estimate(), START)[0] < 0.1


def test_checkpoint_after_restore_is_unchanged_before_a_scan():
    first = AmclUnderTest()
    first.step()
    (checkpoint,) = first.graph.checkpoints()
    second = AmclUnderTest(initial=Pose2D(4.0, 1.0, 0.0))
    second.graph.restore([checkpoint])
    assert second.graph.checkpoints() == [checkpoint]


def call(amcl: AmclUnderTest, service: str) -> list[object]:
    answers: list[object] = []
    amcl.graph.call(service, Empty(), answers.append)
    return answers


def test_global_localization_finds_the_robot():
    amcl = AmclUnderTest(initial=Pose2D(5.2, 1.0, 3.0))
    amcl.step()
    assert error_of(amcl.estimate(), START)[0] > 1.0
    assert call(amcl, "global_localization") == [Empty()]
    for _ in range(20):
        amcl.world.move(0.5, 0.3, 0.3)
        amcl.step()
    assert error_of(amcl.estimate(), amcl.world.pose)[0] < 0.15


def test_restored_clone_continues_global_localization():
    first = AmclUnderTest(initial=Pose2D(5.2, 1.0, 3.0))
    call(first, "global_localization")
    (checkpoint,) = first.graph.checkpoints()
    second = AmclUnderTest(initial=Pose2D(5.2, 1.0, 3.0))
    second.graph.restore([checkpoint])
    for _ in range(20):
        second.world.move(0.5, 0.3, 0.3)
        second.step()
    assert error_of(second.estimate(), second.world.pose)[0] < 0.15


def test_requested_nomotion_update_runs_once():
    amcl = AmclUnderTest()
    amcl.step()
    assert call(amcl, "request_nomotion_update") == [Empty()]
    amcl.step()
    amcl.step()
    assert len(amcl.clouds) == 2


def test_odometry_reset_keeps_the_pose():
    amcl = AmclUnderTest()
    amcl.world.odom = Pose2D(40.0, 20.0, 1.0)
    amcl.step()
    amcl.world.move(0.06, 0.0, 1.0)  # not far enough for an update
    amcl.step()
    amcl.world.odom = Pose2D(0.0, 0.0, 0.0)
    amcl.step()
    amcl.world.move(0.5, 0.0, 1.0)
    amcl.step()
    assert error_of(amcl.estimate(), amcl.world.pose)[0] < 0.1


def drive(amcl: AmclUnderTest, *, steps: int, turn: float = 0.0) -> None:
    for _ in range(steps):
        amcl.world.move(0.2, turn, 1.0)
        amcl.step()


def test_a_robot_that_restarts_elsewhere_is_searched_on_the_whole_map():
    amcl = AmclUnderTest()
    drive(amcl, steps=8)
    believed = amcl.estimate()
    elsewhere = Pose2D(4.5, 1.2, 2.0)
    amcl.world.pose, amcl.world.odom = elsewhere, Pose2D(0.0, 0.0, 0.0)
    amcl.clock.advance(20.0)
    amcl.step()
    drive(amcl, steps=12, turn=0.4)
    assert believed.distance_to(elsewhere) > 1.5
    assert error_of(amcl.estimate(), amcl.world.pose)[0] < 0.2


def test_a_silence_alone_is_no_restart():
    amcl = AmclUnderTest()
    drive(amcl, steps=8)
    scattered = len(amcl.clouds)
    amcl.clock.advance(20.0)
    drive(amcl, steps=1)
    assert len(amcl.clouds[scattered].poses) < 2000


def test_scan_older_than_the_last_is_refused_with_the_difference():
    amcl = AmclUnderTest()
    amcl.odom(100.0)
    amcl.odom(101.0)
    amcl.scan(101.0)
    with pytest.raises(InvalidInput, match=r"0\.500 s before"):
        amcl.scan(100.5)


def test_scans_of_several_lasers_may_come_in_any_order():
    """Each driver has its own delay, so stamps of a front and a rear laser interleave."""
    amcl = AmclUnderTest()
    amcl.graph.inject("tf_static", TFMessage([transform_message("base_link", "rear", Pose2D(0.0, 0.0), Time())]))
    amcl.odom(100.0)
    amcl.odom(101.0)
    amcl.scan(101.0)
    rear = amcl.world.scan(100.8)
    rear.header.frame_id = "rear"
    amcl.graph.inject("scan", rear)
    amcl.scan(101.0)
    assert [round(pose.header.stamp.seconds(), 1) for pose in amcl.poses] == [101.0, 100.8, 101.0]
    rear.header.stamp = Time.of(100.7)
    with pytest.raises(InvalidInput, match=r"0\.100 s before"):
        amcl.graph.inject("scan", rear)


def test_localization_continues_after_the_clock_is_set_back():
    amcl = AmclUnderTest()
    amcl.step()
    amcl.clock.now = 50.0
    amcl.step()
    assert amcl.poses[-1].header.stamp.seconds() == pytest.approx(50.1)


def test_scan_whose_angle_max_does_not_fit_is_used_with_one_warning(caplog):
    """Drivers whose ``angle_max`` is that of the last revolution, or of one beam more, and one that is NaN."""
    amcl = AmclUnderTest()
    for angle_max in (math.pi, 3.0, 4.0, math.nan):
        amcl.clock.advance(0.1)
        amcl.odom()
        scan = amcl.world.scan(amcl.clock())
        scan.angle_max = angle_max
        amcl.graph.inject("scan", scan)
        assert error_of(amcl.estimate(), START)[0] < 0.1
    assert [record.getMessage() for record in caplog.records if "angle_max" in record.getMessage()] == [
        "scans of 'base_scan' have 180 ranges, +3 to what angle_max says: angle_min and angle_increment are believed"
    ]


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda s: s.ranges.clear(), "no ranges"),
        (lambda s: s.ranges.__delitem__(slice(80, None)), "must have 181 ranges, not 80"),
        (lambda s: setattr(s, "angle_increment", 2.0), "358.00 rad"),  # degrees
        (lambda s: setattr(s, "angle_increment", 0.0), "0.00 rad"),
        (lambda s: setattr(s, "angle_min", math.nan), "finite"),
    ],
)
def test_scan_whose_angles_are_not_those_of_a_scan_is_refused(change, why):
    amcl = AmclUnderTest()
    amcl.odom()
    scan = amcl.world.scan(100.0)
    change(scan)
    with pytest.raises(InvalidInput, match=why):
        amcl.graph.inject("scan", scan)
    assert amcl.status() == f"scans are refused: {refusal_of(amcl, scan)}"
    amcl.scan(100.0)
    assert amcl.status() == ""


def refusal_of(amcl, scan) -> str:
    with pytest.raises(InvalidInput) as refused:
        amcl.graph.inject("scan", scan)
    return str(refused.value)


def test_scans_ahead_of_odometry_wait_in_their_order():
    """As in tf2's message filter: none takes the place of another, and they are used as odometry comes."""
    amcl = AmclUnderTest()
    amcl.odom(100.0)
    for stamp in (100.1, 100.3, 100.2):
        amcl.scan(stamp)
    assert not amcl.poses
    amcl.odom(100.25)
    amcl.odom(100.3)
    assert [round(pose.header.stamp.seconds(), 3) for pose in amcl.poses] == [100.1, 100.2, 100.3]


def test_the_oldest_of_many_scans_that_wait_is_dropped():
    amcl = AmclUnderTest()
    amcl.odom(100.0)
    for count in range(150):
        amcl.scan(100.1 + 0.005 * count)
    amcl.odom(100.9)
    assert len(amcl.poses) == 100


def test_scans_of_another_clock_are_told_and_dropped():
    """When odometry reaches their stamps, the robot is elsewhere."""
    amcl = AmclUnderTest()
    amcl.odom(100.0)
    amcl.scan(103.0)
    assert amcl.status() == "scans are stamped 3.0 s ahead of the newest odometry: stamp both with the same clock"
    amcl.odom(103.5)
    assert not amcl.poses
    amcl.scan(103.5)
    assert len(amcl.poses) == 1
    assert amcl.status() == ""


def test_scans_that_waited_for_long_are_dropped():
    amcl = AmclUnderTest()
    amcl.odom(100.0)
    amcl.scan(100.9)
    amcl.clock.advance(31.0)
    amcl.odom(131.0)
    assert not amcl.poses


def test_scans_do_not_wait_for_a_clock_that_was_set_back():
    amcl = AmclUnderTest()
    amcl.odom(100.0)
    amcl.scan(100.1)
    amcl.odom(50.0)
    amcl.scan(50.0)
    amcl.odom(50.1)
    assert [pose.header.stamp.seconds() for pose in amcl.poses] == [50.0]


def test_initial_pose_may_name_the_map_by_its_prefix():
    amcl = AmclUnderTest(initial=Pose2D(5.0, 4.5, 3.0))
    for frame in ("", "/map", "robot1/map"):
        amcl.graph.inject("initialpose", initial_pose(START, frame))
    amcl.step()
    assert error_of(amcl.estimate(), START)[0] < 0.1


def test_transform_with_a_zero_quaternion_is_left_out_and_named():
    amcl = AmclUnderTest()
    broken = TransformStamped(Header(frame_id="base_link"), "camera", Transform(Vector3(), Quaternion(z=0.0, w=0.0)))
    good = transform_message("base_link", "arm", Pose2D(0.1, 0.0), Time())
    with pytest.raises(TransformError, match=r"'base_link' → 'camera' is left out: .*quaternion"):
        amcl.graph.inject("tf_static", TFMessage([broken, good]))
    amcl.odom()
    scan = amcl.world.scan(100.0)
    scan.header.frame_id = "arm"
    amcl.graph.inject("scan", scan)
    assert amcl.poses


def test_scan_with_half_of_its_ranges_invalid_is_accepted():
    amcl = AmclUnderTest()
    amcl.odom()
    scan = amcl.world.scan(100.0)
    scan.ranges[::4] = [math.nan] * len(scan.ranges[::4])
    scan.ranges[2::4] = [math.inf] * len(scan.ranges[2::4])
    amcl.graph.inject("scan", scan)
    assert error_of(amcl.estimate(), START)[0] < 0.1


def test_initial_pose_outside_the_map_is_refused_with_its_bounds():
    amcl = AmclUnderTest()
    with pytest.raises(InvalidInput, match=r"\(7, 1\) is outside the map, which covers 6 × 5 m from \(0, 0\)"):
        amcl.graph.inject("initialpose", initial_pose(Pose2D(7.0, 1.0)))


def test_a_robot_that_was_brought_to_another_map_begins_at_its_initial_pose():
    first = AmclUnderTest()
    first.step()
    second = AmclUnderTest(initial=START, now=103.0)
    second.graph.restore([Checkpoint("amcl", b'{"pose":[90,90,1],"covariance":[],"odom":null}')], of_other_map=True)
    second.step()
    assert error_of(second.estimate(), second.world.pose)[0] < 0.1
