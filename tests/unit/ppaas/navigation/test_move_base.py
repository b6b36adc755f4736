"""Transitions of Move Base: goals, cancels, planning."""

import math

import numpy as np
import pytest

from ppaas.controllers.base import Velocity
from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.navigation.events import (
    CancelReceived,
    ControlFailed,
    Goal,
    GoalMoved,
    GoalReceived,
    GoalUpdated,
    PlanBlocked,
    PlanFailed,
    PlanSucceeded,
    PosesPassed,
    Preempted,
    RecoveryEnded,
    RecoveryStepped,
    VelocityComputed,
)
from ppaas.navigation.move_base import (
    CancelPlan,
    ComputeVelocity,
    FollowPlan,
    GoalPhase,
    PublishFeedback,
    PublishGoal,
    PublishResult,
    PublishStatus,
    Recover,
    RequestPlan,
    SendVelocity,
    StopBase,
)
from ppaas.navigation.parameters import MoveBaseParameters, RecoveryBehavior
from tests.support.world.move_base_driver import BLOCKED, HERE, PLAN, THERE, Driver

# -- goals -------------------------------------------------------------------------------------------------------------


def test_no_orders_without_a_goal():
    driver = Driver()
    assert driver.tick() == []
    assert driver.feed(CancelReceived(driver.now)) == []
    assert driver.feed(VelocityComputed(driver.now, Velocity(1.0, 0.0))) == []


def test_goal_is_published_and_planned_in_the_next_cycle():
    driver = Driver()
    driver.goal()
    assert driver.one(PublishGoal).goal.id == "a"
    assert driver.of(PublishStatus)
    assert driver.status() is Status.ACTIVE
    driver.tick()
    assert driver.one(RequestPlan).goal == THERE
    assert driver.one(PublishFeedback).pose == HERE


def test_only_one_plan_is_requested_at_once():
    driver = Driver()
    driver.to_planning()
    for _ in range(100):
        driver.tick()
        assert not driver.of(RequestPlan)


def test_a_plan_is_followed():
    driver = Driver()
    driver.to_controlling()
    assert driver.one(FollowPlan).poses is PLAN
    driver.tick()
    assert driver.one(ComputeVelocity).pose == HERE
    driver.feed(VelocityComputed(driver.now, Velocity(0.3, 0.1)))
    assert driver.orders == [SendVelocity(Velocity(0.3, 0.1))]


def test_reached_goal_stops_and_succeeds_with_the_text_of_ros():
    driver = Driver()
    driver.to_controlling()
    driver.feed(VelocityComputed(driver.now, Velocity(), goal_reached=True))
    result = driver.one(PublishResult)
    assert (result.goal.id, result.status, result.text) == ("a", Status.SUCCEEDED, "Goal reached. Plans: 1 computed.")
    assert driver.of(StopBase)
    assert driver.machine.goals.active is None
    assert driver.tick() == []


def test_new_goal_preempts_the_old_one_and_its_plan():
    driver = Driver()
    number = driver.to_planning()
    driver.goal("b", Pose2D(1, 1, 0))
    result = driver.one(PublishResult)
    assert (result.goal.id, result.status) == ("a", Status.PREEMPTED)
    assert driver.one(CancelPlan).number == number
    assert driver.one(PublishGoal).goal.id == "b"
    driver.feed(PlanSucceeded(driver.now, number, PLAN))
    assert driver.orders == [], "the plan of the goal before must not be followed"
    driver.tick()
    assert driver.one(RequestPlan).goal == Pose2D(1, 1, 0)


def test_driving_robot_stops_on_a_new_goal_until_it_has_a_plan():
    driver = Driver()
    driver.to_controlling()
    driver.tick()
    driver.feed(VelocityComputed(driver.now, Velocity(0.5, 0.0)))
    driver.goal("b")
    driver.tick()
    assert driver.of(StopBase)


def test_the_same_goal_sent_again_is_the_same_goal():
    driver = Driver()
    driver.to_controlling()
    assert driver.goal("a") == []
    assert driver.machine.state is GoalPhase.CONTROLLING


def test_goal_that_has_just_ended_does_not_restart():
    driver = Driver()
    driver.to_controlling()
    driver.feed(VelocityComputed(driver.now, Velocity(), goal_reached=True))
    assert driver.goal("a") == []
    driver.now += 6.0
    assert driver.goal("a") != [], "after actionlib's status_list_timeout the id is forgotten"


# -- cancelling --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("cancel_id", "stamp"), [("", 0.0), ("a", 0.0), ("", 150.0), ("other", 150.0), ("a", 10.0)]
)  # fmt: skip
def test_matching_cancel_preempts_the_goal(cancel_id, stamp):
    driver = Driver()
    driver.to_controlling()
    driver.feed(CancelReceived(driver.now, cancel_id, stamp))
    assert driver.one(PublishResult).status is Status.PREEMPTED
    assert driver.of(StopBase)
    assert driver.machine.goals.active is None


@pytest.mark.parametrize(("cancel_id", "stamp"), [("other", 0.0), ("", 50.0), ("other", 50.0)])
def test_cancel_of_other_goals_does_nothing(cancel_id, stamp):
    driver = Driver()
    driver.to_controlling()
    assert driver.feed(CancelReceived(driver.now, cancel_id, stamp)) == []
    assert driver.status() is Status.ACTIVE


def test_cancelling_while_planning_cancels_the_plan():
    driver = Driver()
    number = driver.to_planning()
    driver.feed(CancelReceived(driver.now))
    assert driver.one(CancelPlan).number == number


def test_cancelling_while_recovering_stops_the_robot():
    driver = Driver(max_planning_retries=0)
    driver.to_planning()
    driver.fail_plan()
    driver.tick()
    driver.feed(RecoveryStepped(driver.now, Velocity(0.0, 1.0)))
    assert driver.orders == [SendVelocity(Velocity(0.0, 1.0))]
    driver.feed(CancelReceived(driver.now))
    assert driver.of(StopBase)
    assert driver.tick() == []


# -- planning ----------------------------------------------------------------------------------------------------------


def test_a_final_error_aborts_at_once_with_the_planners_reason():
    driver = Driver()
    driver.to_planning()
    driver.fail_plan(GoalOutsideMap("the goal x=99 lies outside the map"), final=True)
    result = driver.one(PublishResult)
    assert result.status is Status.ABORTED
    assert result.text == "Failed to find a valid plan. the goal x=99 lies outside the map"
    assert driver.of(StopBase)


def test_planning_is_retried_at_planner_frequency_until_patience_ends():
    driver = Driver(planner_frequency=2.0, planner_patience=5.0)
    driver.to_planning()
    requested = [driver.now]
    driver.fail_plan()
    for _ in range(200):
        driver.tick()
        if driver.of(RequestPlan):
            requested.append(driver.now)
            driver.fail_plan()
        if driver.machine.state is GoalPhase.CLEARING:
            break
    assert 5.0 <= driver.now - requested[0] <= 5.8
    assert min(np.diff(requested)) > 0.49
    assert "no way" in driver.text


def test_planning_is_retried_each_cycle_without_planner_frequency():
    driver = Driver(planner_frequency=0.0)
    driver.to_planning()
    driver.fail_plan()
    driver.tick()
    assert driver.of(RequestPlan)


def test_max_planning_retries_ends_patience_early():
    driver = Driver(planner_frequency=0.0, max_planning_retries=2)
    driver.to_planning()
    driver.fail_plan()
    for _ in range(2):
        assert driver.machine.state is GoalPhase.PLANNING
        driver.tick()
        driver.fail_plan()
    assert driver.machine.state is GoalPhase.CLEARING


def test_goal_is_aborted_after_all_recoveries_failed():
    driver = Driver(planner_patience=0.5)
    driver.to_planning()
    driver.fail_plan()
    recovered = []
    for _ in range(1000):
        driver.tick()
        if driver.of(RequestPlan):
            driver.fail_plan(GoalOccupied("the goal is not free"))
        for order in driver.of(Recover):
            recovered.append(order.index)
            driver.feed(RecoveryEnded(driver.now))
        if driver.machine.goals.active is None:
            break
    result = driver.one(PublishResult)
    assert result.status is Status.ABORTED
    expected = "Failed to find a valid plan. Even after executing recovery behaviors."
    assert result.text == f"{expected} the goal is not free"
    assert recovered == [0, 1, 2, 3]


def test_goal_is_aborted_without_recovery_when_patience_ends():
    driver = Driver(recovery_behavior_enabled=False, planner_patience=0.0)
    driver.to_planning()
    driver.tick()
    driver.feed(PlanFailed(driver.now, 1, BLOCKED))
    assert driver.one(PublishResult).status is Status.ABORTED


def test_plan_is_renewed_and_followed_while_driving():
    driver = Driver(planner_frequency=1.0)
    driver.to_controlling()
    for _ in range(20):
        driver.tick()
        assert driver.of(ComputeVelocity)
        if driver.of(RequestPlan):
            break
    number = driver.one(RequestPlan).number
    driver.feed(PlanSucceeded(driver.now, number, PLAN))
    assert driver.of(FollowPlan)


def test_failed_replan_keeps_the_current_plan():
    driver = Driver(planner_frequency=1.0)
    driver.to_controlling()
    driver.tick(seconds=1.1)
    assert driver.fail_plan(final=True) == []
    driver.tick()
    assert driver.of(ComputeVelocity)


def test_no_replanning_without_planner_frequency():
    driver = Driver(planner_frequency=0.0)
    driver.to_controlling()
    for _ in range(100):
        driver.tick()
        assert not driver.of(RequestPlan)


# -- what comes too late -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "late",
    [
        VelocityComputed(200.0, Velocity(1.0, 0.0)),
        VelocityComputed(200.0, Velocity(), goal_reached=True),
        ControlFailed(200.0),
        RecoveryStepped(200.0, Velocity(1.0, 0.0)),
        RecoveryEnded(200.0),
        PlanSucceeded(200.0, 77, PLAN),
        PlanFailed(200.0, 77, BLOCKED, final=True),
    ],
)
def test_late_answer_changes_nothing(late):
    driver = Driver()
    driver.to_planning()
    assert driver.feed(late) == []
    assert driver.machine.state is GoalPhase.PLANNING


@pytest.mark.parametrize(
    "wrong",
    [
        {"controller_frequency": 0.0},
        {"planner_patience": -1.0},
        {"planner_timeout": math.inf},
        {"oscillation_distance": math.nan},
        {"recovery_behaviors": (RecoveryBehavior("a", "wait"), RecoveryBehavior("a", "back_up"))},
        {"recovery_behaviors": (RecoveryBehavior("", "wait"),)},
        {"recovery_behaviors": (RecoveryBehavior("a", "wait"),) * 33},
    ],
)
def test_parameters_out_of_range_are_refused_by_name(wrong):
    with pytest.raises(InvalidParameter, match=next(iter(wrong))):
        MoveBaseParameters(**wrong)


# -- poses on the way, and other things to do --------------------------------------------------------------------------


def test_plans_go_through_the_poses_that_were_not_passed():
    driver = Driver()
    driver.feed(GoalReceived(driver.now, Goal("a", THERE, driver.now, (HERE, THERE), many=True)))
    driver.tick()
    order = driver.one(RequestPlan)
    assert (order.goal, order.through) == (THERE, (HERE, THERE))
    driver.feed(PlanSucceeded(driver.now, order.number, PLAN))
    assert driver.feed(PosesPassed(driver.now, 1)) == []
    assert driver.machine.goals.active.goal.through == (THERE,)
    driver.tick(seconds=2.0)
    assert driver.one(RequestPlan).through == (THERE,)


def test_poses_that_are_passed_without_a_goal_are_ignored():
    assert Driver().feed(PosesPassed(100.0, 1)) == []


def test_goal_ends_and_the_robot_stops_if_it_does_something_else():
    driver = Driver()
    assert driver.feed(Preempted(driver.now, "why")) == []
    driver.to_controlling()
    driver.feed(Preempted(driver.now, "Replaced by another goal: turn"))
    result = driver.one(PublishResult)
    assert (result.status, result.text) == (Status.PREEMPTED, "Replaced by another goal: turn")
    assert driver.of(StopBase)
    assert driver.status() is None


def test_feedback_counts_the_recoveries_of_the_goal():
    driver = Driver()
    driver.goal()
    driver.fail_plans_until_recovery()
    driver.tick()
    assert driver.one(PublishFeedback).recoveries == 1
    driver.goal("b")
    driver.tick()
    assert driver.one(PublishFeedback).recoveries == 0


# -- maps that change --------------------------------------------------------------------------------------------------


def test_robot_stops_and_plans_again_if_its_plan_is_blocked_on_another_map():
    driver = Driver(planner_frequency=0.0)
    driver.to_controlling()
    driver.feed(VelocityComputed(driver.now, Velocity(0.3, 0.0)))
    driver.feed(PlanBlocked(driver.now))
    driver.one(StopBase)
    driver.tick()
    assert driver.of(RequestPlan) and driver.machine.state is GoalPhase.PLANNING


@pytest.mark.parametrize("frequency", [0.0, 1.0])
def test_a_goal_that_has_moved_is_the_goal_of_the_next_plan(frequency):
    driver = Driver(planner_frequency=frequency)
    driver.to_controlling()
    moved = Pose2D(THERE.x + 0.4, THERE.y, THERE.theta)
    driver.feed(GoalMoved(driver.now, moved))
    assert bool(driver.of(StopBase)) is (frequency == 0.0)
    for _ in range(25):
        driver.tick()
        if driver.of(RequestPlan):
            break
    assert driver.one(RequestPlan).goal == moved
    assert driver.one(PublishFeedback).goal.pose == moved


@pytest.mark.parametrize("frequency", [0.0, 1.0])
def test_a_goal_that_a_client_updates_is_planned_to_at_once_while_the_robot_drives_on(frequency):
    driver = Driver(planner_frequency=frequency)
    driver.to_controlling()
    driver.feed(VelocityComputed(driver.now, Velocity(0.3, 0.0)))
    elsewhere = Pose2D(THERE.x + 0.4, THERE.y, THERE.theta)
    driver.feed(GoalUpdated(driver.now, elsewhere, 0.4))
    assert driver.one(PublishGoal).updated and not driver.of(StopBase)
    driver.tick()
    assert driver.one(RequestPlan).goal == elsewhere
    assert driver.of(ComputeVelocity) and driver.machine.state is GoalPhase.CONTROLLING
    assert driver.machine.goals.active.goal.speed_limit == 0.4
    driver.feed(PlanSucceeded(driver.now, driver.machine._number, PLAN))
    driver.tick()
    assert not driver.of(RequestPlan)


def test_an_update_of_the_speed_limit_alone_requests_no_plan():
    driver = Driver(planner_frequency=0.0)
    driver.to_controlling()
    driver.feed(GoalUpdated(driver.now, THERE, 0.2))
    driver.tick()
    assert not driver.of(RequestPlan)


def test_without_a_goal_nothing_moves_or_is_blocked():
    driver = Driver()
    assert driver.feed(GoalMoved(driver.now, THERE)) == [] == driver.feed(PlanBlocked(driver.now))
    assert driver.feed(GoalUpdated(driver.now, THERE, 0.0)) == []
