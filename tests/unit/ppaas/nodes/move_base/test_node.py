"""Node ``move_base``: its topics and services."""

import pytest

from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import Duration, Header, Time
from ppaas.messages.codec import decode, encode
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseActionFeedback, MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.messages.nav2_motions import WaitActionGoal, WaitGoal
from ppaas.messages.nav2_msgs import ClearEntireCostmapRequest, ClearEntireCostmapResponse, SpeedLimit
from ppaas.messages.nav_msgs import Path
from ppaas.messages.people_coordination import GoalUpdate
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.tracing.spans import within
from tests.support.recorded_spans import recorded_spans
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, fill, walled_map

START = Pose2D(1.0, 1.0, 0.0)
GOAL = Pose2D(4.0, 3.0, 0.0)


@pytest.fixture
def driving() -> ClosedLoop:
    driving = ClosedLoop(World(walled_map(6, 4, []), START))
    for _ in range(6):
        driving.step()
    return driving


def stamped(pose: Pose2D, frame: str = "map") -> PoseStamped:
    return PoseStamped(Header(frame_id=frame), Pose.of(pose))


def listen(driving: ClosedLoop, topic: str) -> list:
    messages: list = []
    driving.graph.tap(topic, lambda _, message: messages.append(message))
    return messages


def call(driving: ClosedLoop, service: str, request):
    answers: list = []
    driving.graph.call(service, request, answers.append)
    (answer,) = answers
    return answer


def test_goal_of_an_action_client_keeps_its_id(driving):
    status, feedback = listen(driving, "move_base/status"), listen(driving, "move_base/feedback")
    goal_id = GoalID(Time(50, 0), "rviz-7")
    driving.graph.inject("move_base/goal", MoveBaseActionGoal(MoveBaseGoal(stamped(GOAL)), goal_id))
    driving.run(1.0)
    statuses = decode(GoalStatusArray, encode(status[-1])).status_list
    assert [(each.goal_id.id, each.status) for each in statuses] == [("rviz-7", Status.ACTIVE)]
    assert statuses[0].goal_id.stamp == Time(50, 0)
    parsed = decode(MoveBaseActionFeedback, encode(feedback[-1]))
    assert parsed.status.goal_id.id == "rviz-7"
    assert parsed.feedback.base_position.header.frame_id == "map"
    driving.run(30.0)
    result = decode(MoveBaseActionResult, encode(driving.results[0]))
    assert (result.status.goal_id.id, result.status.status) == ("rviz-7", Status.SUCCEEDED)


def test_status_is_published_once_a_second_without_a_goal(driving):
    status = listen(driving, "move_base/status")
    driving.run(3.05)
    assert len(status) == 3
    assert not status[-1].status_list


def test_current_goal_and_plan_are_published(driving):
    current, plans = listen(driving, "move_base/current_goal"), listen(driving, "plan")
    driving.send_goal(GOAL)
    assert current[0].pose.planar() == pytest.approx(GOAL)
    path = decode(Path, encode(plans[0].to_message()))
    assert path.header.frame_id == "map"
    assert path.poses[-1].pose.planar() == pytest.approx(GOAL)


def test_generated_goal_ids_are_unique(driving):
    for _ in range(3):
        driving.send_goal(GOAL)
    driving.graph.inject("move_base/cancel", GoalID())
    ids = [result.status.goal_id.id for result in driving.results]
    assert len(set(ids)) == 3
    assert all(each.startswith("move_base-") for each in ids)


PARENT = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"


def test_the_plans_of_a_goal_are_parts_of_its_span_until_its_result(driving):
    goal = MoveBaseActionGoal(MoveBaseGoal(stamped(GOAL)), GoalID(Time(50, 0), "mine"))
    with recorded_spans() as recorded:
        with within(PARENT):
            driving.graph.inject("move_base/goal", goal)
        driving.run(1.0)
        assert "goal" not in {span.name for span in recorded}
        with within("00-1af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"):
            driving.graph.inject("move_base/goal", goal)  # the same one, sent again
        driving.run(30.0)
    [ended] = [span for span in recorded if span.name == "goal"]
    plans = [span for span in recorded if span.name == "plan"]
    assert plans and {span.parent for span in plans} == {ended.id}
    assert (ended.trace, ended.parent) == (PARENT[3:35], PARENT[36:52])
    assert ended.attributes.items() >= {"ppaas.goal": "mine", "ppaas.goal.status": "succeeded"}.items()
    assert not ended.error


def test_each_goal_has_a_span_and_one_that_is_refused_has_failed(driving):
    with recorded_spans() as recorded:
        for name in ("first", "second"):
            goal_id = GoalID(Time(50, 0), name)
            driving.graph.inject("move_base/goal", MoveBaseActionGoal(MoveBaseGoal(stamped(GOAL)), goal_id))
        outside = MoveBaseActionGoal(MoveBaseGoal(stamped(Pose2D(0.0, 0.0, 0.0))), GoalID(Time(51, 0), "in the wall"))
        driving.graph.inject("move_base/goal", outside)
        driving.run(60.0)
    goals = {span.attributes["ppaas.goal"]: span for span in recorded if span.name == "goal"}
    assert [goals[name].attributes["ppaas.goal.status"] for name in ("first", "second")] == ["preempted"] * 2
    assert len({span.trace for span in goals.values()}) == 3
    assert (goals["in the wall"].error, bool(goals["in the wall"].message)) == ("aborted", True)


def test_goal_is_cancelled_by_its_id(driving):
    goal_id = GoalID(Time(50, 0), "mine")
    driving.graph.inject("move_base/goal", MoveBaseActionGoal(MoveBaseGoal(stamped(GOAL)), goal_id))
    driving.graph.inject("move_base/cancel", GoalID(id="other"))
    assert not driving.results
    driving.graph.inject("move_base/cancel", GoalID(id="mine"))
    assert driving.last_status() is Status.PREEMPTED


def test_clear_costmaps_removes_seen_obstacles(driving):
    cells = driving.world.grid.data.copy()
    fill(cells, driving.world.grid.info, (2.0, 0.5, 2.2, 1.5))
    driving.world.truth[:] = cells >= 50
    driving.send_goal(GOAL)
    driving.run(1.0)
    around = driving.graph.nodes["move_base"]._surroundings
    static = driving.layers.costmap
    assert around.overlay(static) is not static
    driving.graph.inject("move_base/cancel", GoalID())
    assert call(driving, "move_base/clear_costmaps", Empty()) == Empty()
    assert around.overlay(static) is static


@pytest.mark.parametrize(
    "service", ["global_costmap/clear_entirely_global_costmap", "local_costmap/clear_entirely_local_costmap"]
)
def test_the_services_of_nav2_clear_one_costmap_each(driving, service):
    cells = driving.world.grid.data.copy()
    fill(cells, driving.world.grid.info, (2.0, 0.5, 2.2, 1.5))
    driving.world.truth[:] = cells >= 50
    driving.send_goal(GOAL)
    driving.run(0.3)
    driving.graph.inject("move_base/cancel", GoalID())
    around, static = driving.graph.nodes["move_base"]._surroundings, driving.layers.costmap
    driving.world.truth[:] = driving.world.grid.data >= 50
    assert call(driving, service, ClearEntireCostmapRequest()) == ClearEntireCostmapResponse()
    assert around.overlay(static) is not static, "the other one keeps its obstacles"
    for name in ("global_costmap/clear_entirely_global_costmap", "local_costmap/clear_entirely_local_costmap"):
        call(driving, name, ClearEntireCostmapRequest())
    assert around.overlay(static) is static


def test_layers_to_clear_may_be_named_and_unknown_ones_are_refused(driving):
    service = "global_costmap/clear_entirely_global_costmap"
    answer = call(driving, service, ClearEntireCostmapRequest(plugins=["obstacle_layer", "voxel_layer"]))
    assert answer == ClearEntireCostmapResponse(success=True)
    refused = call(driving, service, ClearEntireCostmapRequest(plugins=["obstacle_layer", "static_layer"]))
    assert isinstance(refused, InvalidInput)
    assert "no obstacles are observed in 'static_layer'; name obstacle_layer or voxel_layer" in str(refused)


@pytest.mark.parametrize(("maps", "beyond", "left"), [
    ("both", 0.0, False), ("local", 0.0, True), ("global", 0.0, True), ("both", 0.5, False), ("both", 2.0, True),
])  # fmt: skip
def test_local_and_global_obstacles_are_cleared_separately(driving, maps, beyond, left):
    cells = driving.world.grid.data.copy()
    fill(cells, driving.world.grid.info, (2.0, 0.5, 2.2, 1.5))
    driving.world.truth[:] = cells >= 50
    driving.send_goal(GOAL)
    driving.run(0.3)
    around = driving.graph.nodes["move_base"]._surroundings
    around.clear(driving.world.pose, beyond, maps)
    static = driving.layers.costmap
    assert (around.overlay(static) is not static) is left


def test_robots_in_another_frame_are_refused(driving):
    with pytest.raises(TransformError, match="odom"):
        driving.graph.inject("robots", RobotStates(Header(frame_id="odom"), []))


def test_speed_limit_is_part_of_the_checkpoint(driving):
    driving.graph.inject("speed_limit", SpeedLimit(20.0, percentage=True))
    again = ClosedLoop(driving.world)
    again.graph.nodes["move_base"].restore(driving.graph.nodes["move_base"].checkpoint())
    again.send_goal(GOAL)
    again.run(3.0)
    assert 0.05 < max(command.linear.x for command in again.commands) <= 0.2 * 0.65 + 1e-9


def test_checkpoint_without_a_speed_limit_restores_none(driving):
    driving.graph.nodes["move_base"].restore(b'{"goal":null,"counter":3}')
    driving.send_goal(GOAL)
    driving.run(3.0)
    assert max(command.linear.x for command in driving.commands) > 0.4


def test_restored_goal_is_reached_once_and_ids_stay_unique(driving):
    driving.send_goal(GOAL)
    state = driving.graph.nodes["move_base"].checkpoint()
    driving.graph.nodes["move_base"].restore(state)
    driving.run(40.0)
    assert [result.status.status for result in driving.results] == [Status.SUCCEEDED]
    again = ClosedLoop(driving.world)
    again.graph.nodes["move_base"].restore(driving.graph.nodes["move_base"].checkpoint())
    again.run(1.0)
    assert not again.commands
    again.send_goal(GOAL)
    again.graph.inject("move_base/cancel", GoalID())
    assert again.results[0].status.goal_id.id.startswith("move_base-2-")


def test_the_goal_of_another_map_ends_where_the_robot_was_brought(driving):
    driving.graph.inject("speed_limit", SpeedLimit(20.0, percentage=True))
    driving.send_goal(GOAL)
    again = ClosedLoop(driving.world)
    again.graph.restore(driving.graph.checkpoints(), of_other_map=True)
    again.run(1.0)
    assert not any(command.linear.x or command.angular.z for command in again.commands)
    [result] = again.results
    assert (result.status.status, "another map" in result.status.text) == (Status.PREEMPTED, True)
    again.send_goal(GOAL)
    again.run(3.0)
    assert max(command.linear.x for command in again.commands) > 0.4, "the limit was of the other map"


def test_idle_robot_runs_no_control_cycle(driving):
    """Without a goal, only the timer of the status runs."""
    ticks = []
    node = driving.graph.nodes["move_base"]
    tick = node._tick
    node._tick = lambda: (ticks.append(driving.clock()), tick())
    driving.run(2.0)
    assert not ticks
    driving.send_goal(GOAL)
    driving.run(1.0)
    driving.graph.inject("move_base/cancel", GoalID())
    during = len(ticks)
    assert during > 5
    driving.run(2.0)
    assert len(ticks) == during


# -- goals that move ---------------------------------------------------------------------------------------------------


def follow(driving: ClosedLoop, goal_id: str = "follow", pose: Pose2D = GOAL) -> None:
    driving.graph.inject("move_base/goal", MoveBaseActionGoal(MoveBaseGoal(stamped(pose)), GoalID(id=goal_id)))


def test_robot_drives_on_while_its_goal_moves_and_stops_at_the_last(driving):
    follow(driving, pose=Pose2D(2.5, 1.0, 0.0))
    driving.run(1.5)
    began = len(driving.commands)
    for step in range(1, 7):
        moved = stamped(Pose2D(2.5 + 0.2 * step, 1.0, 0.0))
        driving.graph.inject("move_base/goal_update", GoalUpdate("follow", moved, 0.4))
        driving.run(0.5)
    speeds = [command.linear.x for command in driving.commands[began:]]
    assert min(speeds) > 0.25
    assert max(speeds[20:]) <= 0.4 + 1e-9
    driving.run(10.0)
    assert driving.last_status() is Status.SUCCEEDED
    assert driving.world.pose.x == pytest.approx(3.7, abs=0.2)


def test_goal_to_follow_a_person_does_not_replace_that_of_a_client(driving):
    results, status = listen(driving, "move_base/result"), listen(driving, "move_base/status")
    follow(driving, "user")
    follow(driving, "follow_person/1", START)
    [result] = results
    assert (result.status.goal_id.id, result.status.status) == ("follow_person/1", Status.REJECTED)
    driving.run(1.0)
    assert [each.goal_id.id for each in status[-1].status_list] == ["user"]


def test_goal_of_a_client_and_a_further_one_to_follow_a_person_replace_that_to_follow_a_person(driving):
    results = listen(driving, "move_base/result")
    for name in ("follow_person/1", "follow_person/2", "user"):
        follow(driving, name)
    ended = [(each.status.goal_id.id, each.status.status) for each in results]
    assert ended == [("follow_person/1", Status.PREEMPTED), ("follow_person/2", Status.PREEMPTED)]


def test_goal_to_follow_a_person_does_not_end_a_behaviour(driving):
    results = listen(driving, "move_base/result")
    driving.graph.inject("wait/goal", WaitActionGoal(goal=WaitGoal(Duration.of(5.0)), goal_id=GoalID(id="pause")))
    follow(driving, "follow_person/1")
    assert [each.status.status for each in results] == [Status.REJECTED]


def test_update_for_another_goal_has_no_effect(driving):
    goals = listen(driving, "move_base/current_goal")
    driving.graph.inject("move_base/goal_update", GoalUpdate("user", stamped(GOAL)))
    follow(driving, "user")
    driving.graph.inject("move_base/goal_update", GoalUpdate("follow", stamped(START)))
    assert [goal.pose.planar() for goal in goals] == [pytest.approx(GOAL)]


def test_update_of_nav2_moves_the_active_goal_unless_it_is_older(driving):
    goals = listen(driving, "move_base/current_goal")
    follow(driving)
    older = PoseStamped(Header(stamp=Time(1, 0), frame_id="map"), Pose.of(START))
    for update in (older, stamped(Pose2D(2.0, 2.0, 0.0))):
        driving.graph.inject("goal_update", update)
    assert [goal.pose.planar()[:2] for goal in goals] == [pytest.approx(GOAL[:2]), pytest.approx((2.0, 2.0))]


@pytest.mark.parametrize("limit", [float("nan"), -0.1])
def test_update_with_a_wrong_speed_limit_is_refused(driving, limit):
    follow(driving)
    with pytest.raises(InvalidInput, match="speed_limit"):
        driving.graph.inject("move_base/goal_update", GoalUpdate("follow", stamped(START), limit))
