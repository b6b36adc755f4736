"""Distance and time that remain to a goal, as clients of Nav2 read them in the feedback of ``navigate_to_pose``.

Other members of the kind are ``distance_remaining``, ``navigation_time`` and ``number_of_recoveries`` of
``navigate_to_pose`` and ``navigate_through_poses``.
"""

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.codec import decode, encode
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseGoal
from ppaas.messages.nav2_msgs import NavigateToPoseActionFeedback
from ppaas.nodes.move_base.goal_progress import SLOWEST, GoalProgress
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, fill, walled_map

HERE, GOAL = Pose2D(0.0, 0.0, 0.0), Pose2D(3.0, 4.0, 0.0)


def corner() -> np.ndarray:
    """Return a plan of 7 m around a corner."""
    points = [(x, 0.0) for x in np.arange(0.0, 3.0, 0.1)] + [(3.0, y) for y in np.arange(0.0, 4.05, 0.1)]
    return np.array([(x, y, 0.0, 0.0, 0.0, 0.0, 1.0) for x, y in points])


def test_before_a_plan_the_distance_is_that_of_the_straight_line_at_full_speed():
    progress = GoalProgress(top_speed=0.5)
    progress.begin(GOAL, 10.0)
    progress.update(HERE, 0.0, 10.0)
    assert (progress.distance, progress.remaining()) == pytest.approx((5.0, 10.0))


def test_distance_is_measured_along_the_plan():
    progress = GoalProgress(top_speed=0.5)
    progress.begin(GOAL, 10.0)
    progress.follow(corner())
    progress.update(HERE, 0.5, 10.0)
    assert progress.distance == pytest.approx(7.0)
    progress.update(Pose2D(2.0, 0.1, 0.0), 0.5, 14.0)
    assert progress.distance == pytest.approx(5.0, abs=0.15)
    assert progress.remaining() == pytest.approx(10.0, abs=0.3)


@pytest.mark.parametrize(
    ("pose", "error"),
    [
        (Pose2D(1.0, 0.2, 0.3), (0.2, 0.3)),
        (Pose2D(1.0, -0.1, -0.5), (-0.1, -0.5)),
        (Pose2D(2.8, 2.0, np.pi / 2), (0.2, 0.0)),
        (Pose2D(3.1, 4.0, np.pi), (-0.1, np.pi / 2)),
    ],
)
def test_tracking_errors_are_to_the_left_of_the_plan_and_against_its_direction(pose, error):
    progress = GoalProgress(top_speed=0.5)
    progress.begin(GOAL, 10.0)
    assert progress.tracking_error(pose) == (0.0, 0.0), "there is no plan yet"
    progress.follow(corner())
    for along in [Pose2D(x, 0.0) for x in np.arange(0.0, 3.1, 0.5)] + [Pose2D(3.0, y) for y in np.arange(0, 4.1, 0.5)]:
        progress.update(along, 0.5, 11.0)
        if along.distance_to(pose) < 0.3:
            break
    progress.update(pose, 0.5, 12.0)
    assert progress.tracking_error(pose) == pytest.approx(error, abs=1e-6)


def test_time_is_estimated_from_the_speed_of_the_last_seconds_and_stays_finite():
    progress = GoalProgress(top_speed=1.0)
    progress.begin(GOAL, 10.0)
    for second in range(60):
        progress.update(HERE, 0.25, 10.0 + second)
    assert progress.remaining() == pytest.approx(5.0 / 0.25, rel=0.01)
    for second in range(600):
        progress.update(HERE, 0.0, 70.0 + second)
    assert progress.remaining() == pytest.approx(5.0 / SLOWEST)


def test_time_under_way_includes_that_in_another_executor():
    progress = GoalProgress(top_speed=1.0)
    progress.begin(GOAL, 10.0)
    progress.resume(7.0)
    assert progress.spent(12.0) == pytest.approx(9.0)


def test_a_new_goal_forgets_the_plan_of_the_last_one():
    progress = GoalProgress(top_speed=1.0)
    progress.begin(GOAL, 10.0)
    progress.follow(corner())
    progress.begin(HERE, 20.0)
    progress.update(Pose2D(1.0, 0.0, 0.0), 1.0, 20.0)
    assert (progress.distance, progress.spent(20.0)) == (1.0, 0.0)


# -- poses on the way --------------------------------------------------------------------------------------------------

HALF_WAY, BEND = Pose2D(1.5, 0.0, 0.0), Pose2D(3.0, 0.0, 0.0)


def through(*poses: Pose2D) -> GoalProgress:
    progress = GoalProgress(top_speed=0.5)
    progress.begin(GOAL, 10.0)
    progress.follow(corner(), poses)
    return progress


def test_the_local_planner_sees_the_plan_to_a_little_beyond_the_next_pose():
    progress = through(HALF_WAY, BEND)
    assert progress.ahead[-1][:2] == pytest.approx((1.7, 0.0), abs=0.11)
    assert progress.take_next() == 1
    assert progress.ahead[-1][:2] == pytest.approx((3.0, 0.2), abs=0.11)
    assert progress.take_next() == 1
    assert progress.ahead[-1][:2] == pytest.approx(GOAL[:2])
    assert progress.take_next() == 0


def test_without_poses_on_the_way_the_local_planner_sees_the_whole_plan():
    progress = through()
    assert np.array_equal(progress.ahead, corner())
    assert progress.take_passed(HALF_WAY) == 0


def test_poses_are_passed_in_order_when_the_robot_comes_near_them_along_the_plan():
    progress = through(HALF_WAY, BEND)
    assert progress.take_passed(Pose2D(0.9, 0.0, 0.0)) == 0
    assert progress.take_passed(Pose2D(1.05, 0.0, 0.0)) == 1
    assert progress.ahead[0][:2] == pytest.approx((1.0, 0.0), abs=0.06)
    assert progress.take_passed(Pose2D(2.0, 0.0, 0.0)) == 0
    assert progress.take_passed(Pose2D(3.0, 0.5, 0.0)) == 1


def test_a_pose_that_is_near_but_far_along_the_plan_is_not_passed():
    there_and_back = np.concatenate([corner(), corner()[::-1]])
    progress = GoalProgress(top_speed=0.5)
    progress.begin(HERE, 10.0)
    progress.follow(there_and_back, (GOAL, HALF_WAY))
    assert progress.take_passed(HALF_WAY) == 0


def test_several_poses_may_be_passed_at_once():
    assert through(Pose2D(1.2, 0.0, 0.0), HALF_WAY, BEND).take_passed(HALF_WAY) == 2


# -- published by Move Base --------------------------------------------------------------------------------------------


def driving_to(goal: Pose2D, driving: ClosedLoop, name: str = "nav") -> list[NavigateToPoseActionFeedback]:
    """Send a goal, and return what is published about its progress."""
    heard: list = []
    driving.graph.tap("navigate_to_pose/feedback", lambda _, message: heard.append(decode(
        NavigateToPoseActionFeedback, encode(message)
    )))  # fmt: skip
    target = PoseStamped(Header(frame_id="map"), Pose.of(goal))
    driving.graph.inject("move_base/goal", MoveBaseActionGoal(MoveBaseGoal(target), GoalID(id=name)))
    return heard


def loop(world: World) -> ClosedLoop:
    driving = ClosedLoop(world)
    for _ in range(6):
        driving.step()
    return driving


def test_time_and_distance_fall_on_the_way_to_the_goal():
    driving = loop(World(walled_map(6, 4, []), Pose2D(1.0, 1.0, 0.0)))
    heard = driving_to(Pose2D(4.0, 3.0, 0.0), driving)
    driving.run(60.0)
    assert {message.status.goal_id.id for message in heard} == {"nav"}
    first, last = heard[0].feedback, heard[-1].feedback
    assert first.estimated_time_remaining.seconds() == pytest.approx(3.6 / 0.65, rel=0.2)
    assert first.distance_remaining == pytest.approx(3.6, abs=0.2)
    assert last.distance_remaining < 0.3
    assert last.estimated_time_remaining.seconds() < 3.0
    spent = [message.feedback.navigation_time.seconds() for message in heard]
    assert spent == sorted(spent)
    assert all(message.feedback.number_of_recoveries == 0 for message in heard)
    assert heard[-1].feedback.current_pose.header.frame_id == "map"


def test_recoveries_are_counted_and_a_restored_goal_goes_on_counting_its_time():
    world = World(walled_map(3, 2.6, []), Pose2D(1.0, 1.0, 0.0))
    driving = loop(world)
    fill(cells := world.grid.data.copy(), world.grid.info, (1.6, 0.0, 1.8, 2.6))
    world.truth[:] = cells >= 50
    heard = driving_to(Pose2D(2.3, 1.0, 0.0), driving)
    driving.run(90.0)
    assert max(message.feedback.number_of_recoveries for message in heard) >= 3
    driving_to(Pose2D(2.3, 1.0, 0.0), driving, "again")
    driving.run(2.0)
    state = driving.graph.nodes["move_base"].checkpoint()
    again = loop(World(walled_map(3, 2.6, []), Pose2D(1.0, 1.0, 0.0)))
    resumed: list = []
    again.graph.tap("navigate_to_pose/feedback", lambda _, message: resumed.append(message))
    again.graph.nodes["move_base"].restore(state)
    again.run(0.5)
    assert 1.9 <= resumed[0].feedback.navigation_time.seconds() <= 2.5
