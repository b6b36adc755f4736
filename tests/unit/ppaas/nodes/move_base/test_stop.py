"""Move Base of a robot that is stopped: it stands, its goals and behaviours wait, and it plans again afterwards."""

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Duration
from ppaas.messages.geometry_msgs import Twist
from ppaas.messages.health.stops import StopState
from ppaas.messages.nav2_motions import SpinActionGoal, SpinGoal
from ppaas.nodes.topics import STOP_STATE
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, walled_map

GOAL = Pose2D(4.0, 3.0, 0.0)
STOPPED = StopState(stopped=True, text="stopped by 'ann'")
FREE = StopState()


@pytest.fixture
def driving() -> ClosedLoop:
    """Return a robot that drives to the goal."""
    driving = ClosedLoop(World(walled_map(6, 4, []), Pose2D(1.0, 1.0, 0.0)))
    driving.run(0.3)
    driving.send_goal(GOAL)
    driving.run(2.0)
    assert driving.command != Twist()
    return driving


def moved(driving: ClosedLoop, seconds: float) -> list[Twist]:
    """Return the velocities other than zero of the next seconds."""
    before = len(driving.commands)
    driving.run(seconds)
    return [command for command in driving.commands[before:] if command != Twist()]


def test_a_stopped_robot_stands_and_goes_on_to_its_goal_by_another_plan(driving: ClosedLoop) -> None:
    driving.graph.inject(STOP_STATE.name, STOPPED)
    assert driving.command == Twist(), "it is sent at once"
    assert "waiting: stopped by 'ann'" in driving.texts
    assert moved(driving, 60.0) == []
    assert not driving.results, "no patience runs out"
    plans = len(driving.plans)
    driving.graph.inject(STOP_STATE.name, FREE)
    driving.run(30.0)
    assert len(driving.plans) > plans
    assert driving.last_status() is Status.SUCCEEDED


def test_a_goal_that_comes_meanwhile_waits(driving: ClosedLoop) -> None:
    driving.graph.inject(STOP_STATE.name, STOPPED)
    plans = len(driving.plans)
    driving.send_goal(Pose2D(1.5, 2.5, 0.0))
    assert moved(driving, 5.0) == []
    assert len(driving.plans) == plans
    driving.graph.inject(STOP_STATE.name, FREE)
    driving.run(30.0)
    assert driving.last_status() is Status.SUCCEEDED


def test_a_goal_that_is_cancelled_meanwhile_is_not_driven_to(driving: ClosedLoop) -> None:
    driving.graph.inject(STOP_STATE.name, STOPPED)
    driving.graph.inject("move_base/cancel", GoalID())
    assert driving.last_status() is Status.PREEMPTED
    driving.graph.inject(STOP_STATE.name, FREE)
    assert moved(driving, 2.0) == []


def test_a_behaviour_waits_until_its_time_is_over() -> None:
    driving = ClosedLoop(World(walled_map(6, 4, []), Pose2D(1.0, 1.0, 0.0)))
    driving.run(0.3)
    driving.graph.inject(STOP_STATE.name, STOPPED)
    texts: list[str] = []
    driving.graph.tap("spin/status", lambda _, message: texts.extend(one.text for one in message.status_list))  # type: ignore[union-attr]
    driving.graph.inject("spin/goal", SpinActionGoal(goal=SpinGoal(1.0, Duration(3, 0))))
    assert moved(driving, 2.0) == []
    assert "waiting: stopped by 'ann'" in texts
    driving.run(2.0)
    assert texts[-1].endswith("stopped by 'ann'")
