"""Driving by hand in a whole clone, without I/O."""

from typing import Any

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Duration
from ppaas.messages.codec import decode, encode
from ppaas.messages.health.stops import StopState
from ppaas.messages.nav2_motions import SpinActionGoal, SpinActionResult, SpinGoal
from ppaas.messages.nav2_msgs import SpeedLimit
from ppaas.messages.operators.teleoperation import TeleopCommand, TeleopState
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, fill, walled_map

START = Pose2D(2.0, 2.0, 0.0)
FAR = Pose2D(5.0, 3.0, 0.0)


class Hands:
    """Clone whose operators drive by hand, on links without delay."""

    def __init__(self, start: Pose2D = START, *, seen: tuple[float, ...] = (), **clone: Any) -> None:
        world = World(walled_map(6, 4, []), start)
        if seen:
            fill(cells := world.grid.data.copy(), world.grid.info, seen)
            world.truth[:] = cells >= 50
        self.driving = ClosedLoop(world, **clone)
        self.states: list[TeleopState] = []
        self.number = 0
        self.driving.graph.tap("teleop_state", lambda _, state: self.states.append(state))
        for _ in range(6):
            self.driving.step()

    def send(
        self, linear: float = 0.0, angular: float = 0.0, *, who: str = "ada", enable: bool = True, request: str = ""
    ) -> None:
        self.number += 1
        seen = self.states[-1].number if self.states else 0
        command = TeleopCommand(f"id-{who}", self.number, linear, angular, enable, seen, 0.0, seen, request, who)
        self.driving.graph.inject("teleop_cmd", command)

    def begin(self, who: str = "ada", request: str = "drive") -> None:
        self.send(who=who, enable=False, request=request)

    def drive(self, linear: float, angular: float = 0.0, *, seconds: float = 1.0, who: str = "ada") -> None:
        """Hold the control for a time [s]."""
        for _ in range(round(seconds / 0.05)):
            self.send(linear, angular, who=who)
            self.driving.step()

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.05)):
            self.driving.step()

    @property
    def state(self) -> TeleopState:
        return self.states[-1]

    @property
    def command(self) -> tuple[float, float]:
        return self.driving.command.linear.x, self.driving.command.angular.z

    @property
    def pose(self) -> Pose2D:
        return self.driving.world.pose


def test_a_robot_drives_as_commanded_and_stops_when_the_control_is_let_go() -> None:
    hands = Hands()
    hands.begin()
    assert (hands.state.driver, hands.state.mode) == ("ada", "ready")
    assert (hands.state.max_linear, hands.state.max_angular) == (0.5, 1.0)
    hands.drive(0.4, seconds=1.0)
    assert hands.command == (0.4, 0.0)
    assert (hands.state.mode, hands.state.command) == ("driving", hands.number)
    assert hands.pose.x == pytest.approx(START.x + 0.4, abs=0.1)
    hands.send(enable=False)
    assert hands.command == (0.0, 0.0), "at once, not with the next cycle"
    assert hands.state.mode == "ready"


def test_a_silent_driver_stops_the_robot_and_loses_the_turn() -> None:
    hands = Hands()
    hands.begin()
    hands.drive(0.4, seconds=0.5)
    hands.wait(0.25)
    assert hands.command == (0.4, 0.0)
    hands.wait(0.15)
    assert hands.command == (0.0, 0.0)
    assert (hands.state.mode, hands.state.text) == ("locked", "no command came for 0.3 s")
    hands.wait(2.0)
    assert (hands.state.driver, hands.state.mode) == ("", "free")
    published = len(hands.states)
    hands.wait(1.0)
    assert len(hands.states) == published, "nobody drives: nothing is published"


def test_the_costmap_stops_the_robot_before_a_wall() -> None:
    hands = Hands()
    hands.begin()
    hands.drive(0.5, seconds=12.0)
    assert hands.command == (0.0, 0.0)
    assert hands.state.mode == "blocked"
    assert hands.pose.x > 5.0
    assert hands.driving.clearance > 0.18
    hands.drive(-0.3, seconds=1.0)
    assert hands.pose.x < 5.5
    assert hands.state.mode == "driving"


def test_the_costmap_stops_the_robot_before_what_only_the_laser_sees() -> None:
    hands = Hands(seen=(3.0, 1.5, 3.2, 2.5))
    hands.begin()
    modes = set()
    for _ in range(80):
        hands.drive(0.5, seconds=0.05)
        modes.add(hands.state.mode)
    assert {"driving", "slowed", "blocked"} <= modes
    assert hands.command == (0.0, 0.0)
    assert hands.driving.clearance > 0.18


def taken_from_its_goal() -> Hands:
    """Return a robot that was taken on its way to a goal, and has been driven since."""
    hands = Hands()
    hands.driving.send_goal(FAR)
    hands.wait(1.0)
    assert hands.command != (0.0, 0.0)
    hands.begin()
    assert hands.command == (0.0, 0.0)
    hands.drive(0.3, seconds=0.5)
    assert {(twist.linear.x, twist.angular.z) for twist in hands.driving.commands[-10:]} == {(0.3, 0.0)}
    return hands


def test_a_goal_waits_and_no_other_is_taken_until_the_robot_is_given_back() -> None:
    hands = taken_from_its_goal()
    hands.driving.send_goal(Pose2D(3.0, 1.0))
    assert [result.status.status for result in hands.driving.results] == [Status.REJECTED]
    assert hands.driving.results[-1].status.text == "ada drives the robot by hand"
    hands.send(enable=False)
    hands.wait(1.0)
    assert hands.command == (0.0, 0.0), "to let go is not to give back"
    assert "waiting: ada drives the robot by hand" in hands.driving.texts
    hands.send(enable=False, request="give back")
    assert hands.state.mode == "free"
    hands.wait(1.0)
    assert hands.command != (0.0, 0.0)
    hands.driving.run(30.0)
    assert hands.driving.last_status() is Status.SUCCEEDED


@pytest.mark.parametrize("ends", ["leaves", "is silent", "is replaced by one who leaves"])
def test_a_goal_ends_if_the_robot_is_not_given_back(ends: str) -> None:
    hands, name = taken_from_its_goal(), "ada"
    if ends == "is replaced by one who leaves":
        name = "bob"
        hands.begin("bob", "take over")
    if ends != "is silent":
        hands.send(who=name, enable=False, request="leave")
    hands.wait(2.2)
    [result] = hands.driving.results
    assert (result.status.status, result.status.text) == (Status.PREEMPTED, f"{name} drives the robot by hand")
    assert hands.command == (0.0, 0.0)
    hands.driving.send_goal(FAR)
    hands.wait(1.0)
    assert hands.command != (0.0, 0.0)


def test_a_stopped_robot_stands_and_its_driver_reads_why() -> None:
    hands = Hands()
    hands.begin()
    hands.drive(0.3, seconds=0.3)
    hands.driving.graph.inject("stop/state", StopState(stopped=True, text="stopped by 'ann'"))
    hands.drive(0.3, seconds=0.2)
    assert hands.command == (0.0, 0.0)
    assert (hands.state.mode, hands.state.text) == ("locked", "stopped by 'ann'")
    hands.driving.graph.inject("stop/state", StopState())
    hands.drive(0.3, seconds=0.2)
    assert hands.command == (0.0, 0.0), "a release moves nothing"
    hands.send(enable=False)
    hands.drive(0.3, seconds=0.2)
    assert hands.command == (0.3, 0.0)


def test_a_behaviour_is_preempted_and_no_other_is_taken_meanwhile() -> None:
    hands = Hands()
    ends: list[SpinActionResult] = []
    hands.driving.graph.tap("spin/result", lambda _, end: ends.append(decode(SpinActionResult, encode(end))))
    for number in range(2):
        goal = SpinActionGoal(goal=SpinGoal(3.0, Duration.of(30.0)), goal_id=GoalID(id=f"spin-{number}"))
        hands.driving.graph.inject("spin/goal", goal)
        hands.wait(0.3)
        if not number:
            hands.begin()
    assert [end.status.status for end in ends] == [Status.PREEMPTED, Status.ABORTED]
    assert ends[-1].status.text == "ada drives the robot by hand"
    assert hands.command == (0.0, 0.0)


def test_another_takes_over_and_the_first_is_not_obeyed_any_more() -> None:
    hands = Hands()
    hands.begin()
    hands.drive(0.4, seconds=0.3)
    hands.begin("bob", "take over")
    assert hands.command == (0.0, 0.0)
    assert hands.state.driver == "bob"
    hands.drive(0.4, seconds=0.3)
    assert hands.command == (0.0, 0.0)
    hands.drive(-0.2, seconds=0.3, who="bob")
    assert hands.command == (-0.2, 0.0)


def test_a_robot_that_sends_nothing_any_more_stops_and_says_why() -> None:
    hands = Hands()
    hands.begin()
    hands.drive(0.3, seconds=0.3)
    hands.driving.sensing = False
    hands.drive(0.3, seconds=1.5)
    assert hands.command == (0.0, 0.0)
    assert hands.state.mode == "locked"
    assert "no localization for 1.0 s" in hands.state.text
    hands.driving.sensing = True
    hands.wait(0.2)
    hands.begin(request="")
    hands.drive(0.3, seconds=0.3)
    assert hands.command == (0.3, 0.0)


def test_limits_of_the_model_of_parameters_and_of_operators_hold() -> None:
    hands = Hands(model="turtlebot3_burger", parameters={"teleop": {"max_vel_theta": 0.7}})
    hands.begin()
    assert (hands.state.max_linear, hands.state.max_angular) == (0.22, 0.7)
    hands.drive(2.0, seconds=0.2)
    assert hands.command == (pytest.approx(0.22), 0.0)
    hands.driving.graph.inject("speed_limit", SpeedLimit(speed_limit=0.1, percentage=False))
    hands.drive(2.0, seconds=0.2)
    assert hands.command == (pytest.approx(0.1), 0.0)


def test_commands_that_come_too_often_are_passed_on_at_the_largest_rate_but_a_stop_at_once() -> None:
    hands = Hands(parameters={"teleop": {"max_rate": 10.0}})
    hands.begin()
    hands.wait(0.2)
    before = len(hands.driving.commands)
    for _ in range(100):
        hands.send(0.3)
    assert len(hands.driving.commands) <= before + 1
    hands.wait(0.1)
    assert hands.command == (0.3, 0.0)
    hands.send(enable=False)
    assert hands.command == (0.0, 0.0)


def test_a_command_that_moves_the_robot_is_passed_on_at_once_but_no_faster_than_the_largest_rate() -> None:
    hands = Hands(parameters={"teleop": {"max_rate": 10.0}})
    hands.begin()
    hands.wait(0.2)
    hands.send(enable=False)
    hands.send(0.3)
    assert hands.command == (0.3, 0.0), "it does not wait because the control was let go just now"
    before = len(hands.driving.commands)
    for _ in range(100):
        hands.send(enable=False)
        hands.send(0.3)
    assert len(hands.driving.commands) == before + 1, "the stop alone"


@pytest.mark.parametrize(
    ("parameters", "reason"),
    [({"follow_path": {}}, "follows paths itself")],
)
def test_a_robot_that_obeys_no_velocities_is_not_driven_by_hand(parameters: dict[str, Any], reason: str) -> None:
    hands = Hands(parameters=parameters)
    hands.begin()
    assert hands.state.mode == "refused"
    assert reason in hands.state.text
    hands.drive(0.3, seconds=0.3)
    assert hands.command == (0.0, 0.0)


def test_the_goal_of_a_robot_that_moves_while_it_is_driven_ends() -> None:
    hands = taken_from_its_goal()
    moved = Hands()
    moved.driving.graph.restore(hands.driving.graph.checkpoints())
    moved.wait(1.0)
    assert moved.driving.last_status() is Status.PREEMPTED
    assert moved.command == (0.0, 0.0)


def test_a_driver_is_not_part_of_a_checkpoint() -> None:
    hands = Hands()
    hands.begin()
    hands.drive(0.3, seconds=0.2)
    moved = Hands()
    moved.driving.graph.restore(hands.driving.graph.checkpoints())
    moved.number = hands.number
    moved.drive(0.3, seconds=0.3)
    assert moved.command == (0.0, 0.0)
    assert moved.state.mode == "free"
