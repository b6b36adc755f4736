"""The planar tf tree."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import TransformError
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from ppaas.transforms.planar import TransformTree, is_level, tf_time, transform_message

poses = st.builds(
    Pose2D, st.floats(-50, 50), st.floats(-50, 50), st.floats(-math.pi, math.pi, exclude_max=True)
)  # fmt: skip


def close(a: Pose2D, b: Pose2D) -> bool:
    return a.distance_to(b) < 1e-6 and abs(wrap_angle(a.theta - b.theta)) < 1e-6


def robot_tree() -> TransformTree:
    tree = TransformTree()
    tree.set("map", "odom", Pose2D(1.0, 2.0, math.pi / 2), 10.0)
    tree.set("odom", "base_link", Pose2D(3.0, 0.0, 0.0), 10.0)
    tree.set_static("base_link", "laser", Pose2D(0.1, 0.0, math.pi))
    return tree


def test_transforms_of_a_chain_are_composed():
    assert close(robot_tree().lookup("map", "laser"), Pose2D(1.0, 5.1, -math.pi / 2))


def test_reverse_lookup_gives_the_inverse():
    tree = robot_tree()
    assert close(tree.lookup("laser", "map"), tree.lookup("map", "laser").inverse())


def test_lookup_between_branches_uses_the_common_ancestor():
    tree = robot_tree()
    tree.set_static("base_link", "camera", Pose2D(0.0, 0.2, 0.0))
    assert close(tree.lookup("camera", "laser"), Pose2D(0.1, -0.2, math.pi))


def test_lookup_of_a_frame_in_itself_is_the_identity():
    assert TransformTree().lookup("base_link", "base_link") == Pose2D(0.0, 0.0, 0.0)


@given(poses, poses, st.floats(0.0, 1.0))
def test_transform_between_two_stamps_is_interpolated(first, last, share):
    tree = TransformTree()
    tree.set("odom", "base_link", first, 100.0)
    tree.set("odom", "base_link", last, 101.0)
    found = tree.lookup("odom", "base_link", 100.0 + share)
    turn = wrap_angle(last.theta - first.theta)
    assert math.isclose(found.x, first.x + share * (last.x - first.x), abs_tol=1e-6)
    assert math.isclose(found.y, first.y + share * (last.y - first.y), abs_tol=1e-6)
    assert abs(wrap_angle(found.theta - first.theta - share * turn)) < 1e-6


def test_headings_are_interpolated_through_pi():
    tree = TransformTree()
    tree.set("odom", "base_link", Pose2D(0, 0, 3.0), 0.0)
    tree.set("odom", "base_link", Pose2D(0, 0, -3.0), 1.0)
    assert abs(abs(tree.lookup("odom", "base_link", 0.5).theta) - math.pi) < 1e-9


@given(poses, poses)
def test_forward_and_reverse_lookup_compose_to_the_identity(a, b):
    tree = TransformTree()
    tree.set("map", "odom", a, 1.0)
    tree.set("odom", "base_link", b, 1.0)
    assert close(tree.lookup("map", "base_link") @ tree.lookup("base_link", "map"), Pose2D(0, 0, 0))


def test_latest_lookup_uses_the_latest_common_time():
    tree = robot_tree()
    tree.set("odom", "base_link", Pose2D(5.0, 0.0, 0.0), 12.0)
    tree.set("map", "odom", Pose2D(0.0, 0.0, 0.0), 11.0)
    assert close(tree.lookup("map", "base_link"), Pose2D(4.0, 0.0, 0.0))


@pytest.mark.parametrize(("map_stamp", "odom_stamp"), [(10.0, 3610.0), (3610.0, 10.0)])
def test_latest_lookup_works_while_the_clock_of_one_sender_is_set(map_stamp, odom_stamp):
    tree = TransformTree()
    tree.set("map", "odom", Pose2D(1.0, 0.0, 0.0), map_stamp)
    tree.set("odom", "base_link", Pose2D(3.0, 0.0, 0.0), odom_stamp)
    assert close(tree.lookup("map", "base_link"), Pose2D(4.0, 0.0, 0.0))


@pytest.mark.parametrize("stamp", [9.9, 10.1])
def test_extrapolation_is_refused_with_frames_and_times(stamp):
    with pytest.raises(TransformError, match=rf"'(map|odom)' → '(odom|base_link)'.*10\.000.*{stamp:.3f}"):
        robot_tree().lookup("map", "base_link", stamp)


def test_unknown_frame_error_lists_the_known_frames():
    with pytest.raises(TransformError, match=r"unknown frame 'velodyne'; known: base_link, laser, map, odom"):
        robot_tree().lookup("map", "velodyne")


def test_unconnected_frames_are_refused_by_name():
    tree = robot_tree()
    tree.set("world", "crane", Pose2D(0, 0, 0), 0.0)
    with pytest.raises(TransformError, match="'crane' and 'map' are not connected"):
        tree.lookup("map", "crane")


def test_transforms_older_than_the_cache_time_are_dropped():
    tree = TransformTree(cache_time=10.0)
    for stamp in (0.0, 5.0, 12.0):
        tree.set("odom", "base_link", Pose2D(stamp, 0, 0), stamp)
    assert tree.lookup("odom", "base_link", 5.0).x == 5.0
    with pytest.raises(TransformError, match=r"from 5\.000"):
        tree.lookup("odom", "base_link", 1.0)


def test_late_transform_is_inserted_in_order():
    tree = TransformTree()
    for stamp in (0.0, 2.0, 1.0):
        tree.set("odom", "base_link", Pose2D(10.0 if stamp == 1.0 else 0.0, 0, 0), stamp)
    assert tree.lookup("odom", "base_link", 1.0).x == 10.0
    assert tree.newest("base_link") == 2.0


def test_equal_stamp_replaces_the_transform():
    tree = TransformTree()
    tree.set("odom", "base_link", Pose2D(1, 0, 0), 1.0)
    tree.set("odom", "base_link", Pose2D(2, 0, 0), 1.0)
    assert tree.lookup("odom", "base_link", 1.0).x == 2.0


def test_history_restarts_when_the_clock_is_set_back():
    tree = TransformTree()
    tree.set("odom", "base_link", Pose2D(1, 0, 0), 1_000_000.0)
    tree.set("odom", "base_link", Pose2D(2, 0, 0), 5.0)
    assert tree.newest("base_link") == 5.0
    assert tree.lookup("odom", "base_link").x == 2.0


@pytest.mark.parametrize("back", [0.5, 2.0, 8.0, 9.9, 12.0])
def test_history_restarts_with_the_second_transform_after_the_clock_was_set_back(back):
    """Other members: an hour, a leap second, daylight saving time; all are a step of the stamps."""
    tree = TransformTree()
    for stamp in (100.0, 100.05, 100.1 - back, 100.15 - back):
        tree.set("odom", "base_link", Pose2D(stamp, 0, 0), stamp)
    assert tree.newest("base_link") == 100.15 - back
    assert tree.lookup("odom", "base_link", 100.12 - back).x == pytest.approx(100.12 - back)
    with pytest.raises(TransformError):
        tree.lookup("odom", "base_link", 100.0)


def test_a_clock_that_is_set_ahead_and_back_again_is_followed():
    tree = TransformTree()
    for stamp in (100.0, 105.05, 105.1, 100.15, 100.2):
        tree.set("odom", "base_link", Pose2D(stamp, 0, 0), stamp)
    assert tree.newest("base_link") == 100.2


def test_a_single_stamp_far_ahead_does_not_keep_the_frame_there():
    tree = TransformTree()
    for stamp in (100.0, 4e9, 100.05):
        tree.set("odom", "base_link", Pose2D(1, 0, 0), stamp)
    assert tree.newest("base_link") == 100.05


def test_two_senders_whose_clocks_differ_clear_nothing():
    tree = TransformTree()
    for step in range(40):
        tree.set("odom", "base_link", Pose2D(step, 0, 0), 100.0 + 0.05 * step - (3.0 if step % 2 else 0.0))
    assert tree.newest("base_link") == pytest.approx(101.9)
    assert tree.lookup("odom", "base_link", 100.1).x == 2.0


def test_transforms_that_come_late_one_by_one_clear_nothing():
    tree = TransformTree()
    for stamp in (100.0, 103.0, 102.0, 101.0):
        tree.set("odom", "base_link", Pose2D(stamp, 0, 0), stamp)
    assert tree.newest("base_link") == 103.0
    assert tree.lookup("odom", "base_link", 101.0).x == 101.0


def test_frame_loop_is_refused():
    with pytest.raises(TransformError, match="loop"):
        robot_tree().set("laser", "map", Pose2D(0, 0, 0), 0.0)
    with pytest.raises(TransformError, match="loop"):
        robot_tree().set_static("laser", "laser", Pose2D(0, 0, 0))


def test_static_transform_turns_an_earlier_static_one_around():
    tree = TransformTree()
    tree.set_static("base_link", "base_footprint", Pose2D(0.1, 0, 0))
    tree.set("odom", "base_footprint", Pose2D(1, 0, 0), 1.0)
    tree.set_static("base_footprint", "base_link", Pose2D(-0.2, 0, 0))
    assert tree.lookup("odom", "base_link").x == pytest.approx(0.8)
    tree = TransformTree()
    tree.set_static("base_link", "base_footprint", Pose2D(0.1, 0, 0))
    tree.set_static("base_footprint", "base_link", Pose2D(-0.2, 0, 0))
    assert tree.lookup("base_footprint", "base_link").x == pytest.approx(-0.2)


def test_invalid_static_transform_leaves_the_tree_unchanged():
    tree = TransformTree()
    tree.set_static("base_link", "base_footprint", Pose2D(0.1, 0, 0))
    with pytest.raises(TransformError):
        tree.set_static("base_footprint", "base_link", Pose2D(math.nan, 0, 0))
    assert tree.lookup("base_link", "base_footprint").x == pytest.approx(0.1)


def test_common_time_is_that_of_the_slowest_moving_frame_between_two():
    tree = robot_tree()
    tree.set("odom", "base_link", Pose2D(0, 0, 0), 12.0)
    assert tree.common_time("map", "laser") == 10.0
    assert tree.common_time("odom", "laser") == 12.0
    assert tree.common_time("base_link", "laser") is None
    assert tree.common_time("map", "velodyne") is None


def test_moving_parent_is_the_frame_of_the_odometry_whatever_its_name():
    tree = TransformTree()
    assert tree.moving_parent("base_link", "map") is None
    tree.set_static("base_footprint", "base_link", Pose2D(0, 0, 0))
    tree.set("odom_combined", "base_footprint", Pose2D(0, 0, 0), 1.0)
    assert tree.moving_parent("base_link", "map") == "odom_combined"
    tree.set("map", "odom_combined", Pose2D(0, 0, 0), 1.0)
    assert tree.moving_parent("base_link", "map") == "odom_combined"
    tree.set_static("world", "map", Pose2D(0, 0, 0))
    assert tree.moving_parent("base_link", "map") == "odom_combined"


def test_message_without_a_stamp_is_of_now():
    tree = TransformTree()
    tree.set_message(transform_message("odom", "base_link", Pose2D(1, 0, 0), Time()), now=7.0)
    assert tree.newest("base_link") == 7.0


def test_frame_can_change_its_parent():
    tree = robot_tree()
    tree.set("map", "base_link", Pose2D(7, 0, 0), 20.0)
    assert tree.lookup("map", "base_link") == Pose2D(7, 0, 0)


@pytest.mark.parametrize(
    ("parent", "child", "pose", "stamp"),
    [
        ("", "b", Pose2D(0, 0, 0), 0.0),
        ("a", "", Pose2D(0, 0, 0), 0.0),
        ("a", "b", Pose2D(math.nan, 0, 0), 0.0),
        ("a", "b", Pose2D(0, 0, math.inf), 0.0),
        ("a", "b", Pose2D(1e300, 0, 0), 0.0),
        ("a", "b", Pose2D(0, -2e9, 0), 0.0),
        ("a", "b", Pose2D(0, 0, 0), math.nan),
        ("a", "a", Pose2D(0, 0, 0), 0.0),
    ],
)
def test_invalid_transform_is_refused_and_changes_nothing(parent, child, pose, stamp):
    tree = TransformTree()
    with pytest.raises(TransformError):
        tree.set(parent, child, pose, stamp)
    assert tree.frames() == ()


@given(poses, st.floats(0, 1e9))
def test_transform_round_trips_through_a_message(pose, stamp):
    tree = TransformTree()
    tree.set_message(transform_message("/map", "odom", pose, Time.of(stamp)))
    assert close(tree.lookup("map", "odom"), pose)


@given(st.integers(0, 2_000_000_000), st.integers(0, 999_999_999))
def test_stamp_is_equal_after_conversion_to_float_and_back(secs, nsecs):
    stamp = Time(secs, nsecs - nsecs % 1000)
    again = Time.of(stamp.seconds())
    assert tf_time(again) == tf_time(stamp)


def test_static_transform_is_valid_at_all_times():
    tree = TransformTree()
    tree.set_message(transform_message("base_link", "laser", Pose2D(1, 0, 0), Time(5)), static=True)
    assert tree.lookup("base_link", "laser", 1e9) == Pose2D(1, 0, 0)


def tilted(rotation: Quaternion) -> TransformStamped:
    return TransformStamped(Header(stamp=Time(), frame_id="base_link"), "camera", Transform(Vector3(), rotation))


@pytest.mark.parametrize(
    "rotation",
    [
        Quaternion(x=-0.5, y=0.5, z=-0.5, w=0.5),
        Quaternion(x=1.0, z=0.0, w=0.0),
        Quaternion(y=0.1, z=0.0, w=0.99),
    ],
)
def test_a_frame_out_of_the_plane_is_refused(rotation):
    assert not is_level(rotation)
    with pytest.raises(TransformError, match="planar"):
        TransformTree().set_message(tilted(rotation))


@pytest.mark.parametrize("rotation", [Quaternion(z=0.0, w=0.0), Quaternion(z=math.nan, w=1.0)])
def test_a_quaternion_that_is_not_a_rotation_is_refused(rotation):
    with pytest.raises(TransformError, match="not a rotation quaternion"):
        TransformTree().set_message(tilted(rotation))


def test_frame_that_jumps_is_at_its_newest_place_only():
    tree = TransformTree()
    for stamp, x in ((1.0, 0.0), (1.2, 0.0), (1.3, 9.0)):
        tree.set("map", "odom", Pose2D(x, 0.0, 0.0), stamp)
        tree.set("odom", "base_link", Pose2D(0.0, 1.0, 0.0), stamp - 0.2)
    assert tree.lookup("map", "base_link") == Pose2D(0.0, 1.0, 0.0)
    tree.keep_newest("odom")
    tree.keep_newest("unknown")
    assert tree.lookup("map", "base_link") == Pose2D(9.0, 1.0, 0.0)
