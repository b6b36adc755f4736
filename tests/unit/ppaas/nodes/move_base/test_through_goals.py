"""Action ``navigate_through_poses`` in a whole clone, without I/O."""

import math

import pytest

from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.codec import decode, encode
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav2_msgs import (
    NavigateThroughPosesActionFeedback,
    NavigateThroughPosesActionGoal,
    NavigateThroughPosesActionResult,
    NavigateThroughPosesGoal,
    WaypointProgress,
)
from ppaas.nodes.move_base.through_goals import MAX_POSES
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, fill, walled_map
from tests.support.world.touring import Tour

START = Pose2D(1.0, 1.0, 0.0)
B, C, D = Pose2D(3.0, 1.0, 0.0), Pose2D(4.5, 2.0, 1.0), Pose2D(3.5, 3.0, math.pi)
OUTSIDE = Pose2D(40.0, 1.0, 0.0)


class Touring:
    """A clone that passes poses, and what it says about it."""

    def __init__(self, start: Pose2D = START, *, walls=(), **clone: object) -> None:
        self.driving = ClosedLoop(World(walled_map(6, 4, list(walls)), start), **clone)
        self.feedback: list[NavigateThroughPosesActionFeedback] = []
        self.results: list[NavigateThroughPosesActionResult] = []
        self.listed: dict[str, list[tuple[str, Status]]] = {}
        self.nearest: dict[Pose2D, float] = {}
        graph = self.driving.graph
        graph.tap("navigate_through_poses/feedback", lambda _, message: self.feedback.append(
            decode(NavigateThroughPosesActionFeedback, encode(message))
        ))  # fmt: skip
        graph.tap("navigate_through_poses/result", lambda _, message: self.results.append(
            decode(NavigateThroughPosesActionResult, encode(message))
        ))  # fmt: skip
        for name in ("navigate_through_poses", "move_base"):
            graph.tap(f"{name}/status", self._on_status)
        for _ in range(6):
            self.driving.step()

    def _on_status(self, topic: str, message) -> None:
        self.listed[topic] = [(each.goal_id.id, Status(each.status)) for each in message.status_list]

    def send(self, *poses: Pose2D, name: str = "tour", frame: str = "map", behavior_tree: str = "") -> None:
        stamped = [PoseStamped(Header(frame_id=frame), Pose.of(pose)) for pose in poses]
        message = NavigateThroughPosesActionGoal(
            goal=NavigateThroughPosesGoal(stamped, behavior_tree), goal_id=GoalID(id=name)
        )
        self.driving.graph.inject("navigate_through_poses/goal", message)
        self.nearest = dict.fromkeys(poses, math.inf)

    def run(self, seconds: float = 90.0) -> NavigateThroughPosesActionResult | None:
        """Simulate until a result comes, at most for a time [s]."""
        had, end = len(self.results), self.driving.clock() + seconds
        while len(self.results) == had and self.driving.clock() < end:
            self.driving.step()
            for pose in self.nearest:
                self.nearest[pose] = min(self.nearest[pose], self.pose.distance_to(pose))
        return self.results[-1] if self.results[had:] else None

    @property
    def pose(self) -> Pose2D:
        return self.driving.world.pose

    @property
    def remaining(self) -> list[int]:
        """The numbers of remaining poses in the feedback, each once."""
        numbers = [message.feedback.number_of_poses_remaining for message in self.feedback]
        return [number for index, number in enumerate(numbers) if numbers[index - 1 : index] != [number]]


@pytest.mark.parametrize("controller", ["dwa", "mppi", "pure_pursuit"])
def test_a_robot_passes_the_poses_without_stopping_and_stops_at_the_last(controller):
    touring = Touring(base_local_planner=controller)
    touring.send(B, C, D)
    result = touring.run()
    assert (result.status.goal_id.id, result.status.status) == ("tour", Status.SUCCEEDED), result.status.text
    assert (result.result.error_code, result.result.error_msg) == (0, "")
    assert touring.pose.distance_to(D) < 0.25
    assert max(touring.nearest.values()) < 0.35
    assert touring.remaining == [3, 2, 1]
    speeds = [command.linear.x for command in touring.driving.commands]
    assert min(speeds[40 : len(speeds) - 60]) > 0.1, "it does not stop on the way"
    assert touring.driving.results == [], "the goal is not one of move_base"


def listed(message) -> list[tuple[int, float, int]]:
    return [(each.waypoint_index, each.waypoint_pose.pose.position.x, each.waypoint_status) for each in message]


def test_each_pose_has_a_status_in_feedback_and_result():
    touring = Touring()
    touring.send(B, C, D)
    touring.run()
    places = [(index, pose.x) for index, pose in enumerate((B, C, D))]
    seen = [listed(message.feedback.waypoint_statuses) for message in touring.feedback]
    passed = [sum(status == WaypointProgress.COMPLETED for _, _, status in statuses) for statuses in seen]
    assert all([each[:2] for each in statuses] == places for statuses in seen)
    assert passed == sorted(passed)
    assert set(passed) == {0, 1, 2}
    assert listed(touring.results[-1].result.waypoint_statuses) == [
        (*place, WaypointProgress.COMPLETED) for place in places
    ]


def test_poses_that_a_failed_goal_did_not_reach_have_failed():
    touring = Touring()
    touring.send(B, OUTSIDE)
    [result] = touring.results
    assert [status for *_, status in listed(result.result.waypoint_statuses)] == [WaypointProgress.FAILED] * 2


def test_feedback_has_distance_and_time_to_the_last_pose():
    touring = Touring()
    touring.send(B, C, D)
    touring.run(1.0)
    feedback = touring.feedback[-1].feedback
    assert feedback.distance_remaining == pytest.approx(5.2, abs=0.5)
    assert feedback.estimated_time_remaining.seconds() > 5.0
    assert feedback.number_of_recoveries == 0
    assert feedback.current_pose.header.frame_id == "map"


@pytest.mark.parametrize("poses", [(B, START), (B, START, B, START), (START, B)])
def test_a_round_trip_does_not_end_where_it_begins(poses):
    touring = Touring()
    touring.send(*poses)
    result = touring.run()
    assert result.status.status == Status.SUCCEEDED, result.status.text
    assert touring.nearest[B] < 0.6
    assert touring.pose.distance_to(poses[-1]) < 0.25
    assert len(touring.feedback) > 5


def test_one_pose_is_a_goal():
    touring = Touring()
    touring.send(Pose2D(1.6, 1.0, 0.0))
    assert touring.run().status.status == Status.SUCCEEDED
    assert touring.remaining == [1]


def test_poses_behind_a_wall_are_not_passed_through_it():
    """A pose 0.7 m away on the other side of a wall is reached around the wall."""
    touring = Touring(Pose2D(1.7, 1.0, 1.57), walls=[(2.0, 0.0, 2.1, 3.0)])
    behind, end = Pose2D(2.4, 1.0, 0.0), Pose2D(4.0, 3.0, 0.0)
    touring.send(behind, end)
    result = touring.run()
    assert result.status.status == Status.SUCCEEDED, result.status.text
    assert touring.nearest[behind] < 0.55


# -- refusals and failures ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("poses", "options", "kind", "text"),
    [
        ((), {}, InvalidInput, "from 1 to 100 poses, not 0"),
        ((B,) * (MAX_POSES + 1), {}, InvalidInput, "not 101: follow_waypoints takes longer lists"),
        ((B, Pose2D(math.nan, 0.0, 0.0)), {}, InvalidInput, "position and orientation of pose 2 must be finite"),
        ((B,), {"frame": "mars"}, TransformError, "pose 1 cannot be transformed into 'map'.*mars"),
        ((B,), {"frame": ""}, InvalidInput, r"pose 1 needs header\.frame_id"),
        ((B,), {"behavior_tree": "x.xml"}, InvalidInput, "behavior trees are not supported"),
    ],
)
def test_an_invalid_list_is_refused_and_the_goal_goes_on(poses, options, kind, text):
    touring = Touring()
    touring.send(B, name="first")
    with pytest.raises(kind, match=text):
        touring.send(*poses, name="second", **options)
    assert [goal for goal, _ in touring.listed["navigate_through_poses/status"]] == ["first"]


def test_a_pose_that_cannot_be_reached_ends_the_goal_with_its_number():
    touring = Touring()
    touring.send(B, OUTSIDE, D)
    [result] = touring.results
    assert (result.status.status, result.result.error_code) == (Status.ABORTED, 9100)
    assert "pose 2 of 3: " in result.result.error_msg
    assert result.result.error_msg == result.status.text


def test_a_pose_that_is_blocked_for_a_while_is_waited_for():
    touring = Touring()
    world = touring.driving.world
    free = world.truth.copy()
    fill(cells := world.grid.data.copy(), world.grid.info, (3.0, 0.0, 3.2, 4.0))
    world.truth[:] = cells >= 50
    touring.send(B, D)
    assert touring.run(6.0) is None
    world.truth[:] = free
    assert touring.run(120.0).status.status == Status.SUCCEEDED
    assert max(message.feedback.number_of_recoveries for message in touring.feedback) >= 1


# -- one goal at once --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("topic", "cancel", "ends"),
    [
        ("navigate_through_poses/cancel", GoalID(), True),
        ("navigate_through_poses/cancel", GoalID(id="tour"), True),
        ("navigate_through_poses/cancel", GoalID(id="other"), False),
        ("move_base/cancel", GoalID(), True),
        ("follow_waypoints/cancel", GoalID(), False),
    ],
)
def test_it_is_cancelled_by_its_own_action_or_with_all_goals_of_move_base(topic, cancel, ends):
    touring = Touring()
    touring.send(B, C)
    touring.run(1.0)
    touring.driving.graph.inject(topic, cancel)
    assert [result.status.status for result in touring.results] == [Status.PREEMPTED] * ends


def test_a_cancel_of_its_action_leaves_other_goals_alone():
    touring = Touring()
    touring.driving.send_goal(B)
    touring.driving.graph.inject("navigate_through_poses/cancel", GoalID())
    assert touring.driving.results == []


def test_goals_of_both_actions_preempt_each_other():
    touring = Touring()
    touring.driving.send_goal(B)
    touring.send(B, C)
    assert touring.driving.last_status() is Status.PREEMPTED
    assert touring.listed["navigate_through_poses/status"] == [("tour", Status.ACTIVE)]
    assert touring.listed["move_base/status"][-1] == ("tour", Status.ACTIVE), "Move Base drives to it"
    touring.driving.send_goal(B)
    assert [result.status.status for result in touring.results] == [Status.PREEMPTED]
    assert len(touring.driving.results) == 1


def test_it_ends_a_list_of_waypoints_that_pauses():
    touring = Touring(parameters={"waypoint_follower": {"waypoint_pause_duration": 2000}})
    tour = Tour(touring.driving)
    tour.send([Pose2D(1.3, 1.0, 0.0), B])
    tour.until("pausing at waypoint 0")
    touring.send(C)
    assert tour.outcome[0] == Status.PREEMPTED


def test_another_container_goes_on_to_the_poses_that_remain():
    touring = Touring()
    touring.send(B, C, D)
    while not touring.feedback or touring.feedback[-1].feedback.number_of_poses_remaining > 2:
        touring.driving.step()
    state = touring.driving.graph.nodes["move_base"].checkpoint()
    again = Touring()
    again.driving.graph.nodes["move_base"].restore(state)
    again.nearest = {B: math.inf, C: math.inf, D: math.inf}
    result = again.run()
    assert (result.status.goal_id.id, result.status.status) == ("tour", Status.SUCCEEDED)
    assert again.remaining == [2, 1]
    assert again.nearest[B] > 0.3 or again.nearest[C] < 0.35
    assert again.feedback[0].feedback.navigation_time.seconds() > 2.0


def test_one_plan_is_enough_for_all_poses():
    touring = Touring(parameters={"move_base": {"planner_frequency": 0.0}})
    touring.send(B, C, D)
    assert touring.run().status.status == Status.SUCCEEDED
    assert touring.remaining == [3, 2, 1]
    assert len(touring.driving.plans) == 1
