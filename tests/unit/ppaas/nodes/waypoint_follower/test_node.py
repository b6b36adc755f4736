"""Node ``waypoint_follower`` in a whole clone, without I/O."""

import math

import pytest

from ppaas.errors import InvalidInput, PPaaSError, TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, Status
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.codec import decode, encode
from ppaas.messages.geometry_msgs import Point, Pose, PoseStamped, Quaternion
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.messages.nav2_msgs import FollowWaypointsActionResult, FollowWaypointsError
from ppaas.messages.nav_msgs import Path
from ppaas.nodes.graph import Graph
from ppaas.nodes.waypoint_follower.node import MappingWaypointFollowerNode, WaypointFollowerParameters
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, walled_map
from tests.support.world.touring import Tour, stamped, waypoints

START = Pose2D(1.0, 1.0, 0.0)
A, B, C = Pose2D(1.8, 1.0, 0.0), Pose2D(1.8, 1.6, math.pi / 2), Pose2D(1.2, 1.6, math.pi)
OUTSIDE = Pose2D(40.0, 1.0, 0.0)


def tour(world: World | None = None, *, start: float = 1000.0, **parameters) -> Tour:
    world = world or World(walled_map(3, 2.6, []), START)
    driving = ClosedLoop(world, start=start, parameters={"waypoint_follower": parameters})
    for _ in range(6):
        driving.step()
    return Tour(driving)


def error(name: str) -> int:
    return int(FollowWaypointsError[name])


# -- along the list ----------------------------------------------------------------------------------------------------


def test_waypoints_are_reached_in_order():
    touring = tour()
    touring.send([A, B, C])
    touring.run(60.0)
    assert touring.outcome == (Status.SUCCEEDED, 0, "The list is done.")
    assert touring.visited == [0, 1, 2]
    assert touring.goals == ["tour/0/0", "tour/0/1", "tour/0/2"]
    assert touring.driving.world.pose.distance_to(C) < 0.2
    parsed = decode(FollowWaypointsActionResult, encode(touring.results[0]))
    assert (parsed.status.goal_id.id, parsed.result.missed_waypoints, parsed.result.error_msg) == ("tour", [], "")
    assert [result.status.status for result in touring.driving.results] == [Status.SUCCEEDED] * 3


def test_list_starts_at_goal_index_and_repeats_number_of_loops():
    touring = tour()
    touring.send([A, B], number_of_loops=1, goal_index=1)
    touring.run(90.0)
    assert touring.outcome[0] == Status.SUCCEEDED
    assert touring.goals == ["tour/0/1", "tour/1/0", "tour/1/1"]


def test_robot_pauses_at_each_reached_waypoint():
    touring = tour(waypoint_pause_duration=1500)
    touring.send([A, B])
    touring.until("pausing at waypoint 0")
    began, sent = touring.driving.clock(), len(touring.driving.commands)
    touring.until("driving to waypoint 1")
    assert touring.driving.clock() - began == pytest.approx(1.5, abs=0.1)
    assert not any(command.linear.x or command.angular.z for command in touring.driving.commands[sent:-1])
    touring.run(60.0)
    assert touring.texts[-3:] == ["driving to waypoint 1", "pausing at waypoint 1", "The list is done."]


def test_feedback_has_the_loop_rate_and_status_one_hertz():
    touring = tour(loop_rate=4.0)
    status, feedback = [], []
    touring.driving.graph.tap("follow_waypoints/status", lambda *arguments: status.append(arguments))
    touring.driving.graph.tap("follow_waypoints/feedback", lambda *arguments: feedback.append(arguments))
    touring.run(3.02)
    assert (len(status), len(feedback)) == (3, 0)
    touring.send([A])
    touring.run(1.02)
    assert len(feedback) == 1 + 4
    touring.driving.graph.inject("follow_waypoints/cancel", GoalID())
    touring.run(2.0)
    assert len(feedback) == 1 + 4


# -- waypoints that cannot be reached ----------------------------------------------------------------------------------


def test_unreachable_waypoint_aborts_the_list_with_the_reason():
    touring = tour()
    touring.send([A, OUTSIDE, B])
    touring.run(60.0)
    status, code, text = touring.outcome
    assert (status, code) == (Status.ABORTED, error("STOP_ON_MISSED_WAYPOINT"))
    assert text.startswith("Waypoint 1 could not be reached: Failed to find a valid plan.")
    (missed,) = touring.results[0].result.missed_waypoints
    assert (missed.waypoint_index, missed.waypoint_pose.pose.planar().x) == (1, pytest.approx(40.0))
    assert "outside the map" in missed.error_msg
    assert touring.results[0].result.error_msg == text


def test_missed_waypoint_is_skipped_without_stop_on_failure():
    touring = tour(stop_on_failure=False)
    touring.send([OUTSIDE, A], number_of_loops=1)
    touring.run(90.0)
    assert touring.outcome == (Status.SUCCEEDED, 0, "The list is done. 1 missed.")
    assert [missed.waypoint_index for missed in touring.results[0].result.missed_waypoints] == [0]
    assert touring.goals == ["tour/0/0", "tour/0/1", "tour/1/0", "tour/1/1"]


def test_loop_without_a_reached_waypoint_is_the_last():
    touring = tour(stop_on_failure=False)
    touring.send([OUTSIDE, OUTSIDE], number_of_loops=2**32 - 1)
    touring.run(1.0)
    assert touring.outcome == (
        Status.ABORTED, error("NO_VALID_WAYPOINTS"), "None of the waypoints could be reached.",
    )  # fmt: skip
    assert len(touring.goals) == 2


# -- cancelling, and goals of other clients ----------------------------------------------------------------------------


@pytest.mark.parametrize("cancel", [GoalID(), GoalID(id="tour")])
def test_cancelled_list_stops_the_robot(cancel):
    touring = tour()
    touring.send([A, B])
    touring.run(1.0)
    assert touring.driving.command.linear.x > 0.1
    touring.driving.graph.inject("follow_waypoints/cancel", GoalID(id="another"))
    assert not touring.results
    touring.driving.graph.inject("follow_waypoints/cancel", cancel)
    assert touring.outcome == (Status.PREEMPTED, 0, "The list was cancelled.")
    assert touring.driving.command.linear.x == 0.0
    touring.run(3.0)
    assert (len(touring.results), len(touring.goals)) == (1, 1)


def test_new_list_replaces_the_old_one():
    touring = tour()
    touring.send([A, B], "old")
    touring.run(1.0)
    touring.send([C], "new")
    assert touring.outcome == (Status.PREEMPTED, 0, "Replaced by another list: new")
    touring.run(60.0)
    assert touring.results[-1].status.goal_id.id == "new"
    assert touring.outcome[0] == Status.SUCCEEDED
    assert touring.goals == ["old/0/0", "new/0/0"]


def test_the_same_list_sent_again_is_the_same_list():
    touring = tour()
    touring.send([A])
    touring.send([A])
    touring.run(60.0)
    touring.send([A])
    touring.run(2.0)
    assert (len(touring.results), len(touring.goals)) == (1, 1)


def test_generated_goal_ids_are_unique():
    touring = tour()
    for _ in range(3):
        touring.send([A], "")
    touring.driving.graph.inject("follow_waypoints/cancel", GoalID())
    ids = {result.status.goal_id.id for result in touring.results}
    assert len(ids) == 3
    assert all(each.startswith("waypoint_follower-") for each in ids)


def other_goal(touring: Tour) -> None:
    touring.driving.send_goal(C)


def goal_of_an_action_client(touring: Tour) -> None:
    goal = MoveBaseActionGoal(MoveBaseGoal(stamped(C)), GoalID(id="rviz-7"))
    touring.driving.graph.inject("move_base/goal", goal)


@pytest.mark.parametrize("at", ["driving to waypoint 0", "pausing at waypoint 0"])
@pytest.mark.parametrize("send", [other_goal, goal_of_an_action_client])
def test_other_goal_of_move_base_ends_the_list(at, send):
    touring = tour(waypoint_pause_duration=3000)
    touring.send([A, B])
    touring.until(at)
    touring.run(0.5)
    send(touring)
    status, code, text = touring.outcome
    assert (status, code) == (Status.PREEMPTED, error("UNKNOWN"))
    assert text.startswith("The list ended at waypoint 0: Replaced by another goal: ")
    had = len(touring.driving.results)
    touring.driving.run(60.0)
    assert len(touring.driving.results) == had + 1
    assert touring.driving.last_status() is Status.SUCCEEDED
    assert touring.driving.world.pose.distance_to(C) < 0.2
    touring.run(4.0)
    assert touring.goals[:1] == ["tour/0/0"]
    assert "tour/0/1" not in touring.goals


@pytest.mark.parametrize("at", ["driving to waypoint 0", "pausing at waypoint 0"])
def test_cancelling_all_move_base_goals_ends_the_list(at):
    touring = tour(waypoint_pause_duration=3000)
    touring.send([A, B])
    touring.until(at)
    touring.driving.graph.inject("move_base/cancel", GoalID())
    assert touring.outcome == (
        Status.PREEMPTED, error("UNKNOWN"), "The list ended at waypoint 0: The goal was cancelled.",
    )  # fmt: skip
    touring.run(4.0)
    assert touring.goals == ["tour/0/0"]


@pytest.mark.parametrize("topic", ["move_base_simple/goal", "goal_pose"])
def test_pose_that_is_published_during_a_pause_ends_the_list(topic):
    touring = tour(waypoint_pause_duration=1000)
    touring.send([A, B])
    touring.until("pausing at waypoint 0")
    touring.driving.graph.inject(topic, stamped(C))
    assert touring.outcome == (
        Status.PREEMPTED, error("UNKNOWN"), "The list ended at waypoint 0: Replaced by another goal: a simple goal",
    )  # fmt: skip


def test_goal_refused_by_move_base_does_not_end_a_pausing_list():
    touring = tour(waypoint_pause_duration=1000)
    touring.send([A, B])
    touring.until("pausing at waypoint 0")
    with pytest.raises(TransformError, match="mars"):
        touring.driving.graph.inject("move_base_simple/goal", stamped(C, "mars"))
    touring.until("driving to waypoint 1")


# -- bad input ---------------------------------------------------------------------------------------------------------

NAN = PoseStamped(Header(frame_id="map"), Pose(Point(math.nan, 1.0), Quaternion(z=0.0, w=1.0)))


@pytest.mark.parametrize(
    ("poses", "numbers", "kind", "text"),
    [
        ([], {}, InvalidInput, "from 1 to 1000 waypoints, not 0"),
        ([A] * 1001, {}, InvalidInput, "not 1001"),
        ([A, NAN], {}, InvalidInput, "position and orientation of waypoint 1 must be finite"),
        ([A, stamped(B, "mars")], {}, TransformError, "waypoint 1 cannot be transformed into 'map'.*mars"),
        ([stamped(A, "")], {}, InvalidInput, r"waypoint 0 needs header\.frame_id"),
        ([A], {"goal_index": 1}, InvalidInput, "goal_index must be from 0 to 0"),
        ([A], {"goal_index": -1}, InvalidInput, "goal_index"),
        ([A], {"number_of_loops": -1}, InvalidInput, "number_of_loops"),
        ([A], {"number_of_loops": 2**40}, InvalidInput, "number_of_loops"),
    ],
)
def test_invalid_list_is_refused_and_the_active_one_continues(poses, numbers, kind, text):
    touring = tour()
    touring.send([A], "good")
    with pytest.raises(PPaaSError, match=text) as refused:
        touring.send(poses, "bad", **numbers)
    assert type(refused.value) is kind
    touring.run(30.0)
    assert [(result.status.goal_id.id, result.status.status) for result in touring.results] == [
        ("good", Status.SUCCEEDED)
    ]


def test_a_waypoint_may_be_given_in_the_frame_of_the_robot():
    touring = tour()
    touring.send([stamped(Pose2D(0.6, 0.0, 0.0), "base_link")])
    touring.run(30.0)
    assert touring.driving.world.pose.distance_to(Pose2D(1.6, 1.0)) < 0.2


# -- checkpoints -------------------------------------------------------------------------------------------------------


def elsewhere(first: Tour, seconds: float = 0.5) -> Tour:
    """Return the clone in another executor, some time later."""
    checkpoints = first.driving.graph.checkpoints()
    second = Tour(ClosedLoop(first.driving.world, start=first.driving.clock() + seconds, **PAUSING))
    second.driving.graph.restore(checkpoints)
    return second


PAUSING: dict = {"parameters": {"waypoint_follower": {"waypoint_pause_duration": 1000}}}


def test_list_continues_in_another_executor_with_waypoint_and_loop():
    first = tour(waypoint_pause_duration=1000)
    first.send([A, B], number_of_loops=1)
    first.until("driving to waypoint 1")
    first.run(0.5)
    second = elsewhere(first)
    assert second.goals == ["tour/0/1"]
    second.run(90.0)
    assert second.goals == ["tour/0/1", "tour/1/0", "tour/1/1"]
    assert second.outcome == (Status.SUCCEEDED, 0, "The list is done.")
    assert [result.status.status for result in second.driving.results] == [Status.SUCCEEDED] * 3


def test_pause_continues_in_another_executor():
    first = tour(waypoint_pause_duration=1000)
    first.send([A, B])
    first.until("pausing at waypoint 0")
    second = elsewhere(first)
    assert (second.goals, second.texts) == ([], ["pausing at waypoint 0"])
    second.run(60.0)
    assert second.outcome[0] == Status.SUCCEEDED
    assert second.goals == ["tour/0/1"]


def test_checkpoint_without_a_list_keeps_the_goal_counter():
    first = tour()
    first.send([A], "")
    first.driving.graph.inject("follow_waypoints/cancel", GoalID())
    second = elsewhere(first)
    assert not second.goals
    second.send([A], "")
    assert second.goals[0].startswith("waypoint_follower-2-")


def test_a_list_on_another_map_ends_where_the_robot_was_brought():
    first = tour(waypoint_pause_duration=1000)
    first.send([A, B], number_of_loops=1)
    second = Tour(ClosedLoop(first.driving.world, start=first.driving.clock() + 0.5, **PAUSING))
    second.driving.graph.restore(first.driving.graph.checkpoints(), of_other_map=True)
    assert second.outcome[0] == Status.PREEMPTED and "another map" in second.outcome[2]
    second.run(5.0)
    assert not second.goals
    assert {result.status.status for result in second.driving.results} <= {Status.PREEMPTED}


FIRST, SECOND = Pose2D(1.0, 1.0, 0.0), Pose2D(9.0, 1.0, 0.0)


def key_frames(*poses: Pose2D) -> Path:
    return Path(Header(), [PoseStamped(Header(stamp=Time.of(float(i))), Pose.of(pose)) for i, pose in enumerate(poses)])


@pytest.fixture
def mapped_tour():
    """Return a graph with a follower that drives to FIRST and then to SECOND, and the targets that it has sent."""
    graph, sent = Graph(), []
    graph.add(lambda context: MappingWaypointFollowerNode(context, WaypointFollowerParameters()))
    graph.tap("move_base/goal", lambda _, message: sent.append(message))
    graph.inject("key_frames", key_frames(Pose2D(0.0, 0.0), Pose2D(10.0, 0.0)))
    graph.inject("follow_waypoints/goal", waypoints([FIRST, SECOND]))
    return graph, sent


def reach(graph: Graph, goal_id: str) -> None:
    status = GoalStatus(GoalID(id=goal_id), Status.SUCCEEDED)
    graph.inject("move_base/result", MoveBaseActionResult(Header(), status, Empty()))


def target(message) -> Pose2D:
    return message.goal.target_pose.pose.planar()


def test_waypoints_move_with_the_key_frames_nearest_to_them(mapped_tour):
    graph, sent = mapped_tour
    graph.inject("key_frames", key_frames(Pose2D(0.0, 0.0), Pose2D(10.0, 0.5), Pose2D(11.0, 0.5)))
    assert len(sent) == 1
    reach(graph, sent[0].goal_id.id)
    assert [target(message) for message in sent] == [FIRST, pytest.approx(Pose2D(9.0, 1.5, 0.0))]


def test_waypoints_stay_in_a_map_that_was_cleared(mapped_tour):
    graph, sent = mapped_tour
    graph.inject("key_frames", key_frames())
    graph.inject("key_frames", key_frames(Pose2D(5.0, 5.0)))
    reach(graph, sent[0].goal_id.id)
    assert target(sent[1]) == SECOND
