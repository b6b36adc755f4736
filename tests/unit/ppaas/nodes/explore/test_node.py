"""Node ``explore``: alone with maps and results that the test makes, and in a whole clone that maps."""

import math

import numpy as np
import pytest

from ppaas.clock import ManualClock
from ppaas.costmap.build_layers import build_layers
from ppaas.exploration.parameters import ExploreParameters
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from ppaas.maps.occupancy import GridMapMessage
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header, String, Time
from ppaas.messages.codec import decode, encode
from ppaas.messages.explore_msgs import ExploreActionGoal, ExploreActionResult, ExploreGoal
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult
from ppaas.messages.nav_msgs import MapMetaData, OccupancyGrid
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.explore.node import ExploreNode
from ppaas.nodes.graph import Graph
from ppaas.transforms.planar import transform_message
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.exploring_loop import ExploringLoop
from tests.support.world.planar_world import World, walled_map

INFO = GridInfo(0.05, 120, 80, Pose2D(0.0, 0.0))
ROBOT = Pose2D(2.0, 2.0, 0.0)


def corridor(left: int = 20, right: int = 80) -> GridMap:
    """Return a corridor of 2 m along x, known from a column to another and unknown beyond."""
    cells = np.full(INFO.shape, UNKNOWN, np.int8)
    cells[20:60, left:right] = FREE
    cells[[20, 59], left:right] = OCCUPIED
    return GridMap(cells, INFO)


def closed() -> GridMap:
    """Return the corridor with walls at both ends."""
    grid = corridor()
    grid.data[20:60, [20, 79]] = OCCUPIED
    return grid


class Alone:
    """The node alone: the test moves the robot, and is its map and Move Base."""

    def __init__(self, **parameters: float) -> None:
        self.clock = ManualClock(1000.0)
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        read = ExploreParameters(**parameters)
        self.node = self.graph.add(lambda context: ExploreNode(context, read, build_layers))
        self.goals: list[MoveBaseActionGoal] = []
        self.cancels: list[str] = []
        self.results: list[ExploreActionResult] = []
        self.texts: list[str] = []
        self.graph.tap("move_base/goal", lambda _, message: self.goals.append(message))
        self.graph.tap("move_base/cancel", lambda _, message: self.cancels.append(message.id))
        self.graph.tap("explore/result", lambda _, message: self.results.append(message))
        self.graph.tap("explore/status", self._on_status)

    def _on_status(self, _: str, message: GoalStatusArray) -> None:
        self.texts += [each.text for each in message.status_list if each.text not in self.texts]

    def place(self, pose: Pose2D = ROBOT) -> None:
        now = Time.of(self.clock())
        parts = (("map", "odom", Pose2D(0.0, 0.0)), ("odom", "base_link", pose))
        self.graph.inject("tf", TFMessage([transform_message(*part, now) for part in parts]))

    def show(self, grid: GridMap) -> None:
        self.graph.inject("map", GridMapMessage(grid))

    def send(self, goal_id: str = "look", *, return_to_start: bool = False) -> None:
        self.graph.inject("explore/goal", ExploreActionGoal(ExploreGoal(return_to_start), GoalID(id=goal_id)))

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.25)):
            self.clock.advance(0.25)
            self.graph.run_due()

    def end_goal(self, status: Status, text: str = "") -> None:
        """End the last goal of Move Base."""
        ended = GoalStatus(self.goals[-1].goal_id, int(status), text)
        self.graph.inject("move_base/result", MoveBaseActionResult(Header(), ended))

    def abort(self) -> None:
        self.end_goal(Status.ABORTED, "Failed to find a valid plan.")
        self.wait(3.0)

    @property
    def target(self) -> Pose2D:
        return self.goals[-1].goal.target_pose.pose.planar()

    @property
    def outcome(self) -> tuple[int, str]:
        return self.results[-1].status.status, self.results[-1].status.text


def exploring(grid: GridMap | None = None, **parameters: float) -> Alone:
    alone = Alone(**parameters)
    alone.place()
    alone.show(grid or corridor())
    alone.send()
    return alone


# -- targets -----------------------------------------------------------------------------------------------------------


def test_robot_is_sent_to_the_nearest_frontier():
    alone = exploring()
    assert alone.goals[-1].goal_id.id == "look/1"
    assert alone.target.x == pytest.approx(1.025)
    assert alone.target.theta == pytest.approx(math.pi, abs=1e-6) or alone.target.theta == pytest.approx(-math.pi)
    assert alone.texts[-1] == "driving to a frontier at (1.0, 2.0)"
    assert alone.node.busy


def test_robot_leaves_a_frontier_to_another_robot_that_is_nearer_to_it():
    alone = Alone()
    beside = RobotStates(Header(frame_id="map"), [Pose.of(Pose2D(0.5, 2.0, 0.0))])
    alone.graph.inject("robots", beside)
    alone.place()
    alone.show(corridor())
    alone.send()
    alone.wait(0.5)
    assert alone.target.x > 2.0


def test_exploring_succeeds_although_a_frontier_is_given_up_if_another_was_seen():
    alone = exploring()
    half = corridor()
    half.data[20:60, 20] = OCCUPIED
    alone.show(half)
    alone.wait(1.0)
    alone.abort()
    alone.abort()
    assert alone.outcome == (Status.SUCCEEDED, "No frontier is left but 1 that the robot gave up.")


def test_goal_is_kept_while_its_frontier_is_there_and_replaced_when_it_is_gone():
    alone = exploring()
    alone.show(corridor(left=19))
    alone.wait(1.0)
    assert len(alone.goals) == 1
    seen = corridor(right=80)
    seen.data[20:60, 20] = OCCUPIED
    alone.show(seen)
    alone.wait(1.0)
    assert len(alone.goals) == 2
    assert alone.target.x == pytest.approx(3.975)


def test_goal_follows_a_frontier_that_moves_away():
    alone = exploring()
    alone.show(corridor(left=5))
    alone.wait(1.0)
    assert [goal.goal_id.id for goal in alone.goals] == ["look/1", "look/2"]
    assert alone.target.x == pytest.approx(0.275)


def test_frontier_that_move_base_aborts_twice_is_given_up():
    alone = exploring()
    alone.abort()
    assert "a frontier was not reached: Failed to find a valid plan." in alone.texts
    assert alone.target.x == pytest.approx(1.025)
    alone.abort()
    assert alone.target.x == pytest.approx(3.975)
    alone.abort()
    alone.abort()
    assert alone.outcome == (
        Status.ABORTED, "No frontier could be reached. The last reason: Failed to find a valid plan.",
    )  # fmt: skip
    assert alone.results[-1].result.unreachable == 2
    assert not alone.node.busy


def test_frontier_that_stays_after_the_robot_has_turned_is_given_up():
    alone = exploring()
    alone.end_goal(Status.SUCCEEDED)
    before = alone.target
    alone.wait(2.0)
    assert alone.target.distance_to(before) == 0.0
    assert math.cos(alone.target.theta - before.theta) == pytest.approx(-1.0)
    alone.end_goal(Status.SUCCEEDED)
    alone.wait(2.0)
    assert alone.target.x == pytest.approx(3.975)
    alone.show(closed())
    alone.wait(1.0)
    status, text = alone.outcome
    assert (status, text) == (Status.SUCCEEDED, "No frontier is left but 1 that the robot gave up.")
    assert alone.cancels == ["look/3"]


def test_robot_without_progress_gives_its_frontier_up():
    alone = exploring(progress_timeout=5.0)
    alone.wait(8.0)
    assert alone.cancels == ["look/1"]
    assert alone.target.x == pytest.approx(3.975)


# -- ends --------------------------------------------------------------------------------------------------------------


def test_exploring_ends_when_no_frontier_is_left_with_area_and_distance():
    alone = exploring()
    alone.wait(0.5)
    alone.place(Pose2D(1.2, 2.0, 0.0))
    alone.wait(0.5)
    alone.show(closed())
    alone.wait(1.0)
    assert alone.outcome == (Status.SUCCEEDED, "No frontier is left.")
    result = decode(ExploreActionResult, encode(alone.results[-1])).result
    assert (result.frontiers, result.unreachable) == (0, 0)
    assert result.area == pytest.approx(40 * 60 * 0.0025)
    assert result.distance == pytest.approx(0.8)
    assert result.exploration_time.seconds() == pytest.approx(2.0)


def test_robot_returns_to_its_start_if_the_goal_says_so():
    alone = Alone()
    alone.place()
    alone.show(corridor())
    alone.send(return_to_start=True)
    alone.show(closed())
    alone.wait(1.0)
    assert alone.target == pytest.approx(ROBOT)
    assert alone.texts[-1] == "returning to the start"
    alone.end_goal(Status.SUCCEEDED)
    assert alone.outcome == (Status.SUCCEEDED, "No frontier is left. The robot is back.")


def test_robot_that_cannot_return_says_why():
    alone = Alone()
    alone.place()
    alone.show(closed())
    alone.send(return_to_start=True)
    alone.end_goal(Status.ABORTED, "a door is shut")
    assert alone.outcome == (
        Status.ABORTED, "No frontier is left. The robot is not back at its start: a door is shut",
    )  # fmt: skip


def test_cancel_ends_the_exploration_and_its_goal():
    alone = exploring()
    alone.graph.inject("explore/cancel", GoalID())
    assert alone.outcome == (Status.PREEMPTED, "The goal was cancelled.")
    assert alone.cancels == ["look/1"]
    alone.wait(3.0)
    assert len(alone.goals) == 1


def test_new_goal_replaces_the_active_one_and_a_known_goal_is_ignored():
    alone = exploring()
    alone.send()
    assert alone.results == []
    alone.send("again")
    assert alone.outcome == (Status.PREEMPTED, "Replaced by another goal: again")
    assert alone.goals[-1].goal_id.id == "again/1"


def test_other_goal_of_move_base_ends_the_exploration():
    alone = exploring()
    alone.end_goal(Status.PREEMPTED, "Replaced by another goal: mine")
    assert alone.outcome == (Status.PREEMPTED, "Exploring has ended: Replaced by another goal: mine")


def test_other_goal_ends_it_while_the_robot_looks_around_too():
    alone = exploring()
    alone.end_goal(Status.SUCCEEDED)
    alone.graph.inject("move_base/goal", MoveBaseActionGoal(alone.goals[0].goal, GoalID(id="mine")))
    assert alone.outcome == (Status.PREEMPTED, "Replaced by another goal: mine")


# -- a robot that stands -----------------------------------------------------------------------------------------------


def test_robot_without_a_pose_or_a_map_says_so_and_gives_up_after_a_while():
    alone = Alone(patience=5.0)
    alone.send()
    assert alone.texts[-1].startswith("waiting: the pose of the robot in the map is unknown")
    alone.place()
    alone.wait(1.0)
    assert alone.texts[-1].startswith("waiting: there is no map yet: no valid message has come on 'map'")
    alone.wait(6.0)
    status, text = alone.outcome
    assert status == Status.ABORTED
    assert text.startswith("The robot waited for 6 s: there is no map yet")


def test_robot_waits_for_another_map_if_the_only_one_is_not_valid():
    alone = Alone()
    alone.place()
    alone.graph.inject("map", OccupancyGrid(Header(), MapMetaData(0.05, 2, 2, Pose.of(Pose2D(0.0, 0.0))), [FREE]))
    alone.send()
    alone.wait(2.0)
    assert not alone.results
    assert alone.texts[-1].startswith("waiting: there is no map yet")
    alone.show(corridor())
    alone.wait(2.0)
    assert alone.goals


def test_robot_outside_the_map_waits_for_it_to_grow():
    alone = Alone()
    alone.place(Pose2D(-3.0, 2.0))
    alone.show(corridor())
    alone.send()
    assert "outside the map" in alone.texts[-1]
    alone.place()
    alone.wait(1.0)
    assert len(alone.goals) == 1


def test_reason_for_which_move_base_stands_is_reported():
    alone = exploring()
    waiting = GoalStatus(alone.goals[-1].goal_id, int(Status.ACTIVE), "waiting: no odometry for 2 s")
    alone.graph.inject("move_base/status", GoalStatusArray(Header(), [waiting]))
    assert alone.texts[-1] == "driving to a frontier at (1.0, 2.0); waiting: no odometry for 2 s"


# -- checkpoints -------------------------------------------------------------------------------------------------------


def test_exploration_continues_from_a_checkpoint_with_its_goal_and_what_it_gave_up():
    alone = exploring()
    alone.abort()
    alone.abort()
    state = alone.node.checkpoint()
    assert state is not None
    other = Alone()
    other.place()
    other.show(corridor())
    other.node.restore(state)
    other.wait(1.0)
    assert other.goals == [], "Move Base has been restored to the goal"
    other.show(closed())
    other.wait(1.0)
    assert other.results[-1].result.unreachable == 1
    assert other.results[-1].result.exploration_time.seconds() == pytest.approx(8.0)


# -- a whole clone -----------------------------------------------------------------------------------------------------


def test_clone_explores_two_rooms_without_a_contact():
    rooms = walled_map(5, 4, [(2.4, 0.0, 2.6, 2.4)])
    loop = ExploringLoop(ClosedLoop(World(rooms, Pose2D(1.0, 1.0, 0.0), range_max=4.0), maps=True))
    loop.send()
    loop.run(120.0)
    assert loop.outcome[0] == Status.SUCCEEDED, loop.texts
    assert loop.results[-1].result.area > 0.85 * 20.0
    assert loop.driving.clearance > 0.18
    areas = [message.feedback.area for message in loop.feedback]
    assert areas[-1] > 2.0 * next(area for area in areas if area)
    assert 1.0 < loop.results[-1].result.distance < 40.0


HALL = World(walled_map(26, 26, []), Pose2D(13.0, 13.0, 0.0), range_max=8.0)


def test_a_hall_wider_than_the_laser_is_explored_if_beams_without_a_reading_are_free() -> None:
    parameters = {"grid_slam": {"inf_is_valid": True}}
    exploring = ExploringLoop(ClosedLoop(HALL, maps=True, parameters=parameters))
    exploring.driving.run(1.0)
    exploring.send()
    exploring.run(6.0)
    assert not exploring.results
    assert exploring.goals
    map_ = exploring.driving.graph.latched("map")
    assert isinstance(map_, GridMapMessage)
    assert (map_.grid.data == FREE).sum() * map_.grid.info.resolution**2 > 50.0
    assert not (map_.grid.data == OCCUPIED).any()


def test_a_robot_that_sees_nothing_is_told_what_mapping_and_the_doctor_say() -> None:
    alone = Alone(patience=5.0)
    alone.place()
    alone.graph.inject("grid_slam/status", String("nothing is mapped: All ranges of the scans are infinite."))
    alone.send()
    alone.wait(7.0)
    [result] = alone.results
    assert result.status.status == Status.ABORTED
    assert "nothing is mapped: All ranges of the scans are infinite." in result.status.text
