"""Move Base of a robot that follows paths itself."""

import pytest

from ppaas.clone.assembly import build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Header, String
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.health.stops import StopState
from ppaas.messages.nav2_msgs import FollowWaypointsActionGoal, FollowWaypointsGoal
from ppaas.nodes.graph import Graph
from tests.support.world.planar_world import walled_map
from tests.support.world.self_driving import SelfDriving


def status(robot: SelfDriving) -> tuple[Status, str]:
    (result,) = robot.results
    return Status(result.status.status), result.status.text


def test_a_path_is_sent_once_and_its_end_is_the_end_of_the_goal():
    robot = SelfDriving()
    robot.send_goal(6.0, 5.0, 1.0)
    assert robot.end_of_path().distance_to(Pose2D(6.0, 5.0)) < 0.1
    for _ in range(5):
        robot.feed_back()
        robot.run(5.0)
    assert len(robot.paths) == 1
    assert robot.text.startswith("controlling")
    assert not robot.results
    robot.pose = Pose2D(5.9, 5.1, 1.1)
    robot.end(Status.SUCCEEDED)
    assert status(robot)[0] is Status.SUCCEEDED
    assert not robot.cancelled
    assert robot.graph.latched("follow_path/goal") is None


def test_a_goal_is_not_reached_where_the_robot_only_says_so():
    robot = SelfDriving()
    robot.send_goal(6.0, 5.0)
    robot.pose = Pose2D(3.0, 1.0)
    robot.run(0.5)
    robot.end(Status.SUCCEEDED)
    code, text = status(robot)
    assert code is Status.ABORTED
    assert "is 5.00 m away" in text


def test_the_direction_at_the_goal_is_checked_where_that_is_wanted():
    robot = SelfDriving(follow_path={"yaw_goal_tolerance": 0.2})
    robot.send_goal(6.0, 5.0, 1.0)
    robot.pose = Pose2D(6.0, 5.0, 0.5)
    robot.run(0.5)
    robot.end(Status.SUCCEEDED)
    assert "turned by 0.50 rad" in status(robot)[1]


def test_a_robot_that_gives_up_ends_its_goal_with_its_reason():
    robot = SelfDriving()
    robot.send_goal(6.0, 5.0)
    robot.end(Status.ABORTED, "the fork is blocked")
    code, text = status(robot)
    assert code is Status.ABORTED
    assert text == "the robot does not follow the path: the fork is blocked"


def test_a_cancelled_goal_cancels_the_path():
    robot = SelfDriving()
    robot.send_goal(6.0, 5.0)
    robot.graph.inject("move_base/cancel", GoalID())
    assert robot.cancelled == [robot.paths[0].goal_id.id]
    assert status(robot)[0] is Status.PREEMPTED
    assert robot.graph.latched("follow_path/goal") is None


def test_another_goal_sends_another_path_in_place_of_the_first():
    robot = SelfDriving()
    robot.send_goal(6.0, 5.0)
    robot.send_goal(2.0, 6.0)
    assert [path.goal_id.id for path in robot.paths] != [robot.paths[0].goal_id.id] * 2
    assert len(robot.paths) == 2
    assert not robot.cancelled, "the robot is told by the second path"
    robot.end(Status.SUCCEEDED, path=robot.paths[0].goal_id.id)
    assert len(robot.results) == 1, "the end of the first path does not end the second goal"


def test_a_robot_that_says_nothing_ends_its_goal():
    robot = SelfDriving(follow_path={"patience": 3.0})
    robot.send_goal(6.0, 5.0)
    robot.run(2.0)
    robot.feed_back()
    robot.run(2.0)
    robot.feed_back("another path")
    assert not robot.results
    robot.run(2.0)
    code, text = status(robot)
    assert code is Status.ABORTED
    assert "publish 'follow_path/feedback'" in text
    assert robot.cancelled == [robot.paths[0].goal_id.id]


def test_a_robot_whose_pose_is_unknown_for_a_while_keeps_its_path():
    robot = SelfDriving()
    robot.send_goal(6.0, 5.0)
    robot.run(8.0, localized=False)
    assert robot.text.startswith("waiting: no odometry for")
    assert not robot.cancelled
    robot.run(1.0)
    assert robot.text.startswith("controlling")
    assert len(robot.paths) == 1


def test_the_status_of_a_goal_says_why_the_robot_is_not_localized():
    robot = SelfDriving()
    robot.send_goal(6.0, 5.0)
    robot.graph.inject("amcl/status", String("the AGV is on map 'hall 2'"))
    robot.run(6.0, localized=False)
    for _ in range(10):
        robot.inject_odometry()
        robot.run(0.1, localized=False)
    assert robot.text == "waiting: not localized: the AGV is on map 'hall 2'"


def test_waypoints_are_paths_one_after_the_other():
    robot = SelfDriving()
    poses = [PoseStamped(Header(frame_id="map"), Pose.of(Pose2D(*at))) for at in ((4.0, 2.0), (4.0, 6.0))]
    robot.graph.inject("follow_waypoints/goal", FollowWaypointsActionGoal(FollowWaypointsGoal(poses)))
    robot.run(0.5)
    for count in (1, 2):
        assert len(robot.paths) == count
        robot.pose = robot.end_of_path()
        robot.run(0.5)
        robot.end(Status.SUCCEEDED)
    assert [result.status.status for result in robot.results] == [Status.SUCCEEDED] * 2


def test_a_goal_is_driven_to_again_by_the_next_container():
    robot = SelfDriving()
    robot.send_goal(6.0, 5.0)
    after = SelfDriving()
    after.graph.restore(robot.graph.checkpoints())
    after.run(0.5)
    assert after.end_of_path().distance_to(Pose2D(6.0, 5.0)) < 0.1
    assert after.paths[0].goal_id.id != robot.paths[0].goal_id.id


def test_a_robot_that_makes_a_map_cannot_follow_paths_itself():
    with pytest.raises(InvalidParameter, match="needs a map"):
        build_clone(Graph(), None, model="turtlebot2", initial_pose=(0.0, 0.0, 0.0), parameters={"follow_path": {}})


@pytest.mark.parametrize("given", [{"patience": 0.0}, {"xy_goal_tolerance": -1.0}, {"speed": 1.0}])
def test_invalid_parameters_are_refused(given):
    layers = build_layers(walled_map(4, 3, []))
    with pytest.raises(InvalidParameter):
        build_clone(
            Graph(), layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters={"follow_path": given}
        )


def test_a_robot_that_is_stopped_loses_its_path_at_once_and_gets_another_after_the_release():
    robot = SelfDriving()
    robot.send_goal(6.0, 5.0)
    robot.graph.inject("stop/state", StopState(stopped=True, text="stopped by 'ann'"))
    assert robot.cancelled == [robot.paths[0].goal_id.id]
    assert robot.graph.latched("follow_path/goal") is None
    robot.run(60.0)
    assert robot.text == "waiting: stopped by 'ann'"
    assert not robot.results
    robot.graph.inject("stop/state", StopState())
    robot.run(0.5)
    assert len(robot.paths) == 2
    robot.pose = Pose2D(6.0, 5.0)
    robot.run(0.5)
    robot.end(Status.SUCCEEDED)
    assert status(robot)[0] is Status.SUCCEEDED


def test_a_robot_that_is_stopped_while_its_path_is_planned_gets_none():
    robot = SelfDriving()
    robot.graph.inject("stop/state", StopState(stopped=True, text="stopped by 'ann'"))
    robot.send_goal(6.0, 5.0)
    robot.run(5.0)
    assert not robot.paths
