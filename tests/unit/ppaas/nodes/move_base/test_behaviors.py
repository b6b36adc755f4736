"""Actions ``spin``, ``backup`` and ``wait`` in a whole clone, without I/O."""

import math

import pytest

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages import nav2_motions
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Duration
from ppaas.messages.codec import decode, encode
from ppaas.messages.geometry_msgs import Point, Twist
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, fill, walled_map

START = Pose2D(2.0, 2.0, 0.0)
FAR = Pose2D(4.0, 3.0, 0.0)


class Behaving:
    """Clone that records the feedback and results of behaviours."""

    def __init__(self, start: Pose2D = START, *, seen: tuple[float, ...] = (), **clone: object) -> None:
        world = World(walled_map(6, 4, []), start)
        if seen:
            fill(cells := world.grid.data.copy(), world.grid.info, seen)
            world.truth[:] = cells >= 50
        self.driving = ClosedLoop(world, **clone)
        self.results: list = []
        self.feedback: list = []
        self.texts: list[str] = []
        for name in ("spin", "backup", "wait"):
            self.driving.graph.tap(f"{name}/result", self._on_result)
            self.driving.graph.tap(f"{name}/feedback", lambda _, message: self.feedback.append(message.feedback))
            self.driving.graph.tap(f"{name}/status", self._on_status)
        for _ in range(6):
            self.driving.step()

    def _on_result(self, topic: str, message) -> None:
        self.results.append(decode(self.driving.graph.topics[topic].type, encode(message)))

    def _on_status(self, _: str, message) -> None:
        self.texts += [each.text for each in message.status_list if self.texts[-1:] != [each.text]]

    def spin(self, target_yaw: float, allowance: float = 30.0, name: str = "b", **fields) -> None:
        goal = nav2_motions.SpinGoal(target_yaw, Duration.of(allowance), **fields)
        message = nav2_motions.SpinActionGoal(goal=goal, goal_id=GoalID(id=name))
        self.driving.graph.inject("spin/goal", message)

    def back_up(self, x: float, speed: float = 0.1, allowance: float = 30.0, *, y: float = 0.0, **fields) -> None:
        goal = nav2_motions.BackUpGoal(Point(x, y), speed, Duration.of(allowance), **fields)
        message = nav2_motions.BackUpActionGoal(goal=goal, goal_id=GoalID(id="b"))
        self.driving.graph.inject("backup/goal", message)

    def wait(self, seconds: float) -> None:
        message = nav2_motions.WaitActionGoal(goal=nav2_motions.WaitGoal(Duration.of(seconds)), goal_id=GoalID(id="b"))
        self.driving.graph.inject("wait/goal", message)

    def run(self, seconds: float = 60.0):
        """Simulate until a behaviour ends, at most for a time [s]; return its result, if there is one."""
        had, end = len(self.results), self.driving.clock() + seconds
        while len(self.results) == had and self.driving.clock() < end:
            self.driving.step()
        return self.results[-1] if self.results[had:] else None

    def still(self) -> bool:
        return self.driving.command == Twist()

    @property
    def pose(self) -> Pose2D:
        return self.driving.world.pose


# -- spin --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("turn", [1.57, -1.57, 2 * math.pi])
def test_a_robot_turns_in_place_by_the_angle(turn):
    behaving = Behaving()
    behaving.spin(turn)
    result = behaving.run()
    assert (result.status.goal_id.id, result.status.status) == ("b", Status.SUCCEEDED)
    assert (result.result.error_code, result.result.error_msg) == (0, "")
    assert abs(wrap_angle(behaving.pose.theta - turn)) < 0.15
    assert behaving.pose.distance_to(START) < 0.05
    traveled = [each.angular_distance_traveled for each in behaving.feedback]
    assert traveled[-1] == pytest.approx(abs(turn), abs=0.15)
    assert 0.0 <= traveled[0] < 0.1
    assert result.result.total_elapsed_time.seconds() == pytest.approx(abs(turn) / 0.9, rel=0.5)
    assert behaving.still()


def test_a_turn_that_takes_too_long_is_aborted_with_what_was_done():
    behaving = Behaving()
    behaving.spin(6.0, allowance=1.0)
    result = behaving.run()
    assert (result.status.status, result.result.error_code) == (Status.ABORTED, 701)
    assert result.result.error_msg.endswith("of 6.00 rad: the time allowance of 1 s has passed")
    assert behaving.still()


def test_an_oblong_robot_does_not_turn_into_a_wall():
    footprint = "[[0.6, 0.15], [0.6, -0.15], [-0.2, -0.15], [-0.2, 0.15]]"
    parameters = {"global_costmap": {"footprint": footprint}}
    behaving = Behaving(Pose2D(2.0, 0.65, 0.0), parameters=parameters)
    behaving.spin(-3.0)
    result = behaving.run()
    assert -1.0 < behaving.pose.theta < -0.1
    assert (result.status.status, result.result.error_code) == (Status.ABORTED, 703)
    assert "no room" in result.result.error_msg
    assert behaving.still()


def test_turns_are_as_fast_as_those_of_the_recovery_of_the_robot():
    behaving = Behaving(parameters={
        "rotate_recovery": {"max_rotational_vel": 0.3, "min_in_place_rotational_vel": 0.2}
    })  # fmt: skip
    behaving.spin(1.0)
    behaving.run()
    assert max(command.angular.z for command in behaving.driving.commands) == pytest.approx(0.3)


# -- backup ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("x", "speed"), [(0.5, 0.2), (-0.5, -0.2), (0.15, 0.025)])
def test_a_robot_backs_up_by_the_distance(x, speed):
    behaving = Behaving()
    behaving.back_up(x, speed)
    result = behaving.run()
    assert result.status.status == Status.SUCCEEDED, result.status.text
    assert behaving.pose.x == pytest.approx(START.x - abs(x), abs=0.06)
    assert behaving.feedback[-1].distance_traveled == pytest.approx(abs(x), abs=0.05)
    assert {command.linear.x for command in behaving.driving.commands} == {0.0, -abs(speed)}
    assert behaving.still()


def test_a_robot_does_not_back_up_into_what_it_sees():
    behaving = Behaving(seen=(1.3, 1.5, 1.4, 2.5))
    behaving.back_up(1.0, 0.2)
    result = behaving.run()
    assert (result.status.status, result.result.error_code) == (Status.ABORTED, 714)
    assert "the space behind is not free" in result.result.error_msg
    assert result.result.error_msg.startswith("backed up by ")
    assert behaving.driving.clearance > 0.15
    assert behaving.still()


def test_no_robot_backs_up_faster_than_it_can():
    behaving = Behaving()
    behaving.back_up(0.3, 50.0)
    behaving.run()
    assert min(command.linear.x for command in behaving.driving.commands) == -0.65


# -- wait --------------------------------------------------------------------------------------------------------------


def test_a_robot_waits_for_the_time():
    behaving = Behaving()
    behaving.wait(1.5)
    result = behaving.run()
    assert result.status.status == Status.SUCCEEDED
    assert result.result.total_elapsed_time.seconds() == pytest.approx(1.5, abs=0.11)
    left = [each.time_left.seconds() for each in behaving.feedback]
    assert left == sorted(left, reverse=True)
    assert not behaving.driving.commands


# -- refusals ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("ask", "code", "text"),
    [
        (lambda robot: robot.spin(math.nan), 700, "target_yaw must be from -100 to 100 rad"),
        (lambda robot: robot.spin(1.0, disable_collision_checks=True), 700, "collision checks cannot be disabled"),
        (lambda robot: robot.back_up(0.3, 0.0), 713, "speed must not be 0"),
        (lambda robot: robot.back_up(0.3, math.nan), 713, "speed"),
        (lambda robot: robot.back_up(0.3, y=0.1), 713, "target.y and target.z must be 0"),
        (lambda robot: robot.back_up(1e9), 713, "target.x"),
        (lambda robot: robot.back_up(0.3, disable_collision_checks=True), 713, "collision checks"),
        (lambda robot: robot.wait(-1.0), 740, "time must be from 0"),
    ],
)
def test_an_invalid_behaviour_is_aborted_with_the_code_of_nav2_and_a_reason(ask, code, text):
    behaving = Behaving()
    behaving.driving.send_goal(FAR)
    ask(behaving)
    [result] = behaving.results
    assert (result.status.status, result.result.error_code) == (Status.ABORTED, code)
    assert text in result.result.error_msg
    assert result.status.text == result.result.error_msg
    assert behaving.driving.graph.nodes["move_base"].busy, "the goal of Move Base goes on"


# -- one thing at once -------------------------------------------------------------------------------------------------


def test_a_behaviour_preempts_the_goal_of_move_base_and_the_next_goal_the_behaviour():
    behaving = Behaving()
    behaving.driving.send_goal(FAR)
    behaving.driving.run(1.0)
    behaving.spin(3.0, name="turn")
    assert behaving.driving.last_status() is Status.PREEMPTED
    assert behaving.driving.results[-1].status.text == "Replaced by another goal: turn"
    behaving.run(0.5)
    behaving.driving.send_goal(FAR)
    [ended] = behaving.results
    assert (ended.status.status, ended.status.text[:26]) == (Status.PREEMPTED, "Replaced by another goal: ")
    behaving.driving.run(60.0)
    assert behaving.driving.last_status() is Status.SUCCEEDED


def test_a_behaviour_preempts_another():
    behaving = Behaving()
    behaving.spin(6.0, name="turn")
    behaving.run(0.5)
    behaving.back_up(0.2)
    assert behaving.run().status.status == Status.SUCCEEDED
    assert [result.status.status for result in behaving.results] == [Status.PREEMPTED, Status.SUCCEEDED]


@pytest.mark.parametrize(
    ("topic", "cancel", "ends"),
    [
        ("spin/cancel", GoalID(), True),
        ("spin/cancel", GoalID(id="b"), True),
        ("spin/cancel", GoalID(id="other"), False),
        ("backup/cancel", GoalID(), False),
        ("move_base/cancel", GoalID(), True),
        ("move_base/cancel", GoalID(id="other"), False),
    ],
)
def test_a_behaviour_is_cancelled_by_its_own_action_or_with_all_goals_of_move_base(topic, cancel, ends):
    behaving = Behaving()
    behaving.spin(6.0)
    behaving.run(0.5)
    behaving.driving.graph.inject(topic, cancel)
    assert [result.status.status for result in behaving.results] == [Status.PREEMPTED] * ends
    assert behaving.still() == ends
    assert behaving.driving.graph.nodes["move_base"].busy != ends


def test_a_goal_that_is_sent_again_is_run_once():
    behaving = Behaving()
    for _ in range(2):
        behaving.spin(1.0)
    behaving.run()
    behaving.spin(1.0)
    assert behaving.run(2.0) is None


# -- troubles ----------------------------------------------------------------------------------------------------------


def test_a_robot_whose_pose_is_lost_stands_and_says_why_until_the_allowance_has_passed():
    behaving = Behaving()
    behaving.spin(6.0, allowance=5.0)
    behaving.run(0.5)
    behaving.driving.sensing = False
    behaving.run(2.0)
    assert behaving.still()
    assert behaving.texts[-1].startswith("waiting: no ")
    result = behaving.run()
    assert (result.status.status, result.result.error_code) == (Status.ABORTED, 702)
    assert "rad: no " in result.result.error_msg


def test_a_base_that_does_not_follow_is_told():
    behaving = Behaving()
    behaving.driving.world.move = lambda *_: None
    behaving.spin(3.0, allowance=4.0)
    result = behaving.run()
    assert any(text.startswith("waiting: the base does not follow cmd_vel") for text in behaving.texts)
    assert (result.status.status, result.result.error_code) == (Status.ABORTED, 701)


def test_another_container_does_what_is_left():
    behaving = Behaving()
    behaving.spin(2.5)
    behaving.run(1.5)
    state = behaving.driving.graph.nodes["move_base"].checkpoint()
    turned = behaving.feedback[-1].angular_distance_traveled
    assert 0.5 < turned < 2.0
    again = Behaving()
    again.driving.graph.nodes["move_base"].restore(state)
    result = again.run()
    assert (result.status.goal_id.id, result.status.status) == ("b", Status.SUCCEEDED)
    assert again.pose.theta == pytest.approx(2.5 - turned, abs=0.2)
    assert result.result.total_elapsed_time.seconds() > 2.0
