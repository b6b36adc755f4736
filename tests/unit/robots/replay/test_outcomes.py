"""Comparison of a drive with its replay."""

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, PoseWithCovarianceStamped, Twist, Vector3
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from robots.replay.outcomes import NO_END, Outcomes, compare


def drive(offset: float = 0.0, *, goals: tuple[tuple[str, Status], ...] = ()) -> Outcomes:
    """Return a drive straight ahead, off by a distance to the left."""
    found = Outcomes()
    for number in range(10):
        pose = PoseWithCovariance(Pose.of(Pose2D(0.1 * number, offset)))
        header = Header(stamp=Time(number + 1), frame_id="map")
        found.take("amcl_pose", PoseWithCovarianceStamped(header, pose), 0.1 * number)
        found.take("cmd_vel", Twist(linear=Vector3(x=0.5 + offset)), 0.1 * number + 0.01)
    for goal, status in goals:
        found.take("move_base/result", MoveBaseActionResult(Header(), GoalStatus(GoalID(id=goal), status)), 1.0)
    return found


def test_equal_drives_do_not_differ() -> None:
    goals = (("g1", Status.SUCCEEDED),)
    found = compare(drive(goals=goals), drive(goals=goals))
    assert (found.poses, found.velocities, found.most_distance, found.linear) == (10, 10, 0.0, 0.0)
    assert not found.differs
    assert found.words()[-1] == "Goal 'g1' ended with SUCCEEDED, as recorded."


def test_far_poses_differ() -> None:
    found = compare(drive(), drive(0.5))
    assert (found.median_distance, found.most_distance) == (0.5, 0.5)
    assert found.linear == pytest.approx(0.5)
    assert found.differs


def test_goal_that_ends_otherwise_differs() -> None:
    found = compare(drive(goals=(("g1", Status.SUCCEEDED),)), drive(goals=(("g1", Status.ABORTED),)))
    assert found.differs
    assert found.words()[-1] == "Goal 'g1' ended with ABORTED, but was recorded as SUCCEEDED."
    assert compare(drive(goals=(("g1", Status.ABORTED),)), drive()).goals == {"g1": ("ABORTED", NO_END)}


def test_goals_without_an_id_are_matched_by_their_order() -> None:
    recorded = drive(goals=(("a-1", Status.SUCCEEDED), ("named", Status.PREEMPTED), ("a-2", Status.ABORTED)))
    replayed = drive(goals=(("b-1", Status.SUCCEEDED), ("named", Status.PREEMPTED), ("b-2", Status.ABORTED)))
    assert not compare(recorded, replayed).differs


def test_nothing_in_common_is_said_so() -> None:
    found = compare(drive(), Outcomes())
    assert found.words() == ["No pose can be compared: there is no scan that both localized."]
    assert not found.differs
