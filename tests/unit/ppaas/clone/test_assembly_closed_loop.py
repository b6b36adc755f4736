"""A whole clone drives a robot in a closed loop, without I/O."""

import math
from collections import deque
from concurrent.futures import ThreadPoolExecutor

import pytest

from ppaas.errors import InvalidInput, PPaaSError, TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Point, Pose, PoseStamped, Quaternion, Twist, Vector3
from ppaas.messages.people_msgs import People, Person
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.nodes.graph import Graph
from ppaas.nodes.move_base.node import MoveBaseNode
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, error_of, fill, walled_map

RADIUS = 0.18
START = Pose2D(1.0, 1.0, math.pi / 2)

# A wall across the room with two doors: y from 1 to 2.2 m, and from 5.8 to 7 m.
TWO_DOORS = [(3.9, 0.0, 4.1, 1.0), (3.9, 2.2, 4.1, 5.8), (3.9, 7.0, 4.1, 8.0)]
ONE_DOOR = [(3.9, 0.0, 4.1, 1.0), (3.9, 2.2, 4.1, 8.0)]
BEYOND = Pose2D(6.5, 1.6, 0.0)


def loop(boxes=(), drift=1.0, pose=START, seed=1, **options) -> ClosedLoop:
    driving = ClosedLoop(World(walled_map(8, 8, list(boxes)), pose, drift=drift, seed=seed), **options)
    for _ in range(6):
        driving.step()
    return driving


def assert_arrived(driving: ClosedLoop, goal: Pose2D) -> None:
    assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text
    distance, turn = error_of(driving.world.pose, goal)
    assert distance < 0.2
    assert turn < 0.3
    assert driving.clearance > RADIUS


@pytest.mark.parametrize("seed", [1, 2])
def test_robot_with_drifting_odometry_reaches_its_goal_and_stops(seed):
    driving = loop(TWO_DOORS, drift=2.0, seed=seed)
    driving.send_goal(BEYOND)
    driving.run(60.0)
    assert_arrived(driving, BEYOND)
    assert driving.worst < 0.15
    stopped = driving.commands[-1]
    assert (stopped.linear.x, stopped.angular.z) == (0.0, 0.0)
    sent = len(driving.commands)
    driving.run(2.0)
    assert len(driving.commands) == sent, "no velocity is published without a goal"


def test_robot_takes_the_other_door_if_one_is_closed():
    driving = loop(TWO_DOORS)
    driving.send_goal(BEYOND)
    driving.run(1.0)
    assert driving.plans[0].length < 7.0
    fill_truth(driving, (3.9, 1.0, 4.1, 2.2))
    driving.run(120.0)
    assert_arrived(driving, BEYOND)
    assert max(plan.length for plan in driving.plans) > 9.0


def test_enclosed_robot_aborts_after_all_recoveries():
    driving = loop(ONE_DOOR, parameters={"move_base": {"planner_patience": 1.0}})
    driving.send_goal(BEYOND)
    driving.run(1.0)
    fill_truth(driving, (3.9, 1.0, 4.1, 2.2))
    driving.run(120.0)
    assert driving.last_status() is Status.ABORTED
    text = driving.results[-1].status.text
    assert text.startswith("Failed to find a valid plan. Even after executing recovery behaviors.")
    assert "no free path" in text
    recovered = {text.split()[2].rstrip(":") for text in driving.texts if text.startswith("recovering by")}
    assert recovered == {"conservative_reset", "rotate_recovery", "aggressive_reset"}
    assert driving.clearance > RADIUS


def test_robot_drives_through_a_reopened_door():
    driving = loop(ONE_DOOR)
    driving.send_goal(BEYOND)
    driving.run(1.0)
    fill_truth(driving, (3.9, 1.0, 4.1, 2.2))
    driving.run(8.0)
    assert not driving.results
    fill_truth(driving, (3.9, 1.0, 4.1, 2.2), occupied=False)
    driving.run(90.0)
    assert_arrived(driving, BEYOND)


def fill_truth(driving: ClosedLoop, box, *, occupied: bool = True) -> None:
    """Add or remove something in the world that is not on the map."""
    cells = driving.world.grid.data.copy()
    fill(cells, driving.world.grid.info, box)
    driving.world.truth[cells != driving.world.grid.data] = occupied


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        (Pose2D(40.0, 1.0, 0.0), "outside the map"),
        (Pose2D(4.0, 4.0, 0.0), "blocked"),
    ],
)
def test_invalid_goal_is_aborted_at_once_with_the_planners_reason(goal, reason):
    driving = loop(TWO_DOORS)
    driving.send_goal(goal)
    driving.run(1.0)
    assert driving.last_status() is Status.ABORTED
    assert reason in driving.results[-1].status.text


def test_a_goal_behind_walls_of_the_map_is_aborted_at_once():
    driving = loop([(3.9, 0.0, 4.1, 8.0)])
    driving.send_goal(BEYOND)
    driving.run(1.0)
    assert driving.last_status() is Status.ABORTED
    assert "no free path" in driving.results[-1].status.text


def test_a_new_goal_preempts_the_old_and_is_reached():
    driving = loop()
    driving.send_goal(Pose2D(6.0, 6.0, 0.0))
    driving.run(3.0)
    other = Pose2D(6.0, 1.5, 0.0)
    driving.send_goal(other)
    driving.run(60.0)
    assert driving.results[0].status.status == Status.PREEMPTED
    driving.run(60.0)
    assert_arrived(driving, other)


def test_a_cancelled_goal_stops_the_robot():
    driving = loop()
    driving.send_goal(Pose2D(6.0, 6.0, 0.0))
    driving.run(3.0)
    assert driving.command.linear.x > 0.1
    driving.graph.inject("move_base/cancel", GoalID())
    assert driving.last_status() is Status.PREEMPTED
    assert (driving.command.linear.x, driving.command.angular.z) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("frame", "pose", "error"),
    [
        ("map", Pose(Point(math.nan, 1.0), Quaternion(z=0.0, w=1.0)), InvalidInput),
        ("map", Pose(Point(1.0, math.inf), Quaternion(z=0.0, w=1.0)), InvalidInput),
        ("map", Pose(Point(1.0, 1.0), Quaternion(z=0.0, w=0.0)), InvalidInput),
        ("", Pose(Point(1.0, 1.0), Quaternion(z=0.0, w=1.0)), InvalidInput),
        ("mars", Pose(Point(1.0, 1.0), Quaternion(z=0.0, w=1.0)), TransformError),
    ],
)
def test_malformed_goal_is_refused_and_the_active_goal_continues(frame, pose, error):
    driving = loop()
    goal = Pose2D(3.0, 3.0, 0.0)
    driving.send_goal(goal)
    driving.run(1.0)
    with pytest.raises(error):
        driving.graph.inject("move_base_simple/goal", PoseStamped(Header(frame_id=frame), pose))
    driving.run(60.0)
    assert [result.status.status for result in driving.results] == [Status.SUCCEEDED]


def test_a_goal_may_be_given_in_the_frame_of_the_robot():
    driving = loop()
    ahead = PoseStamped(Header(frame_id="base_link"), Pose.of(Pose2D(1.0, 0.0, 0.0)))
    driving.graph.inject("move_base_simple/goal", ahead)
    driving.run(30.0)
    assert_arrived(driving, Pose2D(1.0, 2.0, math.pi / 2))


def test_robot_stops_without_sensor_data_and_continues_afterwards():
    driving = loop()
    goal = Pose2D(6.0, 6.0, 0.0)
    driving.send_goal(goal)
    driving.run(3.0)
    assert driving.command.linear.x > 0.1
    driving.sensing = False
    driving.run(1.3)
    assert driving.command.linear.x == 0.0
    assert any(text.startswith("waiting: no odometry for 1.") for text in driving.texts)
    driving.run(20.0)
    assert not driving.results, "a silent robot keeps its goal"
    driving.sensing = True
    driving.run(60.0)
    assert_arrived(driving, goal)


def test_robot_keeps_clear_of_other_robots():
    driving = loop()
    goal, other = Pose2D(6.0, 1.0, 0.0), Pose2D(3.5, 1.1, 0.0)
    driving.send_goal(goal)
    nearest = math.inf
    for _ in range(1200):
        driving.graph.inject("robots", RobotStates(Header(frame_id="map"), [Pose.of(other)]))
        driving.step()
        nearest = min(nearest, driving.world.pose.distance_to(other))
        if driving.results:
            break
    assert_arrived(driving, goal)
    assert nearest > 2 * RADIUS


@pytest.mark.parametrize("planner", ["dwa", "mppi"])
def test_robot_lets_a_crossing_robot_pass(planner):
    driving = loop(base_local_planner=planner)
    driving.send_goal(Pose2D(6.0, 1.0, 0.0))
    other, nearest, twist = Pose2D(3.4, 3.9, -math.pi / 2), math.inf, Twist(linear=Vector3(x=0.5))
    for cycle in range(1200):
        if cycle % 4 == 0:
            states = RobotStates(Header(frame_id="map"), [Pose.of(other)], [twist], [RADIUS])
            driving.graph.inject("robots", states)
        driving.step()
        other = other._replace(y=max(other.y - 0.05 * twist.linear.x, -9.0))
        nearest = min(nearest, driving.world.pose.distance_to(other))
        if driving.results:
            break
    assert_arrived(driving, Pose2D(6.0, 1.0, 0.0))
    assert nearest > 2 * RADIUS


@pytest.mark.parametrize("planner", ["dwa", "mppi", "pure_pursuit"])
def test_robot_keeps_more_distance_to_people(planner):
    nearest, somebody = {}, Pose2D(3.5, 1.45)
    for enabled in (True, False):
        driving = loop(base_local_planner=planner, parameters={"social_layer": {"enabled": enabled}})
        driving.send_goal(Pose2D(6.0, 1.0, 0.0))
        nearest[enabled] = math.inf
        for cycle in range(600):
            if cycle % 4 == 0:
                person = Person("ann", Point(somebody.x, somebody.y), Point(-0.3, 0.0))
                driving.graph.inject("people", People(Header(frame_id="map"), [person]))
            driving.step()
            nearest[enabled] = min(nearest[enabled], driving.world.pose.distance_to(somebody))
            if driving.results:
                break
        assert_arrived(driving, Pose2D(6.0, 1.0, 0.0))
    assert nearest[True] > nearest[False] + 0.1


def test_clone_continues_in_another_executor_from_its_checkpoint():
    first = loop(TWO_DOORS)
    first.send_goal(BEYOND)
    first.run(5.0)
    assert not first.results
    checkpoints = first.graph.checkpoints()

    # Half a second passes between the two executors, during which the robot keeps driving.
    first.world.move(0.3, 0.0, 0.5)
    second = ClosedLoop(first.world, start=first.clock() + 0.5, initial_pose=(0.0, 0.0, 0.0))
    second.graph.restore(checkpoints)
    second.run(60.0)
    assert_arrived(second, BEYOND)
    assert second.results[0].status.goal_id.id.startswith("move_base-1-")
    assert second.worst < 0.2


class ThreadHome:
    """An executor that runs jobs in a thread, and delivers their results in the loop."""

    def __init__(self, pool: ThreadPoolExecutor) -> None:
        self.pool = pool
        self.finished: deque = deque()
        self.running: list = []

    def __call__(self, work, cancelled, done):
        self.running.append(self.pool.submit(self._run, work, cancelled, done))

    def _run(self, work, cancelled, done):
        try:
            result = work(cancelled)
        except PPaaSError as error:
            result = error
        self.finished.append((done, result))

    def attend(self):
        for future in self.running:
            future.result(timeout=30)
        self.running.clear()
        while self.finished:
            done, result = self.finished.popleft()
            done(result)


def test_nodes_drive_with_jobs_in_threads():
    with ThreadPoolExecutor(2) as pool:
        home = ThreadHome(pool)
        driving = loop(TWO_DOORS, worker=home)
        assert isinstance(driving.graph, Graph)
        assert isinstance(driving.graph.nodes["move_base"], MoveBaseNode)
        driving.send_goal(BEYOND)
        for _ in range(1200):
            driving.step()
            home.attend()
            if driving.results:
                break
        assert_arrived(driving, BEYOND)
        assert len(driving.plans) > 3
