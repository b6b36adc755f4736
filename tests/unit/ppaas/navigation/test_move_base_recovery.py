"""Transitions of Move Base: control, recovery, and an unknown pose."""

import pytest

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.navigation.events import (
    ControlFailed,
    PlanDeferred,
    PlanSucceeded,
    RecoveryEnded,
    RecoveryStepped,
    VelocityComputed,
)
from ppaas.navigation.move_base import (
    ComputeVelocity,
    GoalPhase,
    Oscillation,
    PublishResult,
    PublishStatus,
    Recover,
    RequestPlan,
    SendVelocity,
    StopBase,
)
from ppaas.navigation.parameters import MoveBaseParameters, RecoveryBehavior, recovery_behaviors, recovery_defaults
from tests.support.world.move_base_driver import PLAN, Driver

# -- control -----------------------------------------------------------------------------------------------------------


def test_failed_control_stops_and_replans():
    driver = Driver()
    driver.to_controlling()
    driver.tick()
    driver.feed(ControlFailed(driver.now))
    assert driver.of(StopBase)
    assert driver.machine.state is GoalPhase.PLANNING
    driver.tick()
    assert driver.of(RequestPlan)


def fail_control(driver: Driver, cycles: int) -> None:
    """Let planning succeed and control fail."""
    for _ in range(cycles):
        driver.tick()
        for order in driver.of(RequestPlan):
            driver.feed(PlanSucceeded(driver.now, order.number, PLAN))
            driver.tick()
        if driver.of(ComputeVelocity):
            driver.feed(ControlFailed(driver.now))
        for _ in driver.of(Recover):
            driver.feed(RecoveryEnded(driver.now))
        if driver.machine.goals.active is None:
            return


def test_control_failing_beyond_patience_recovers_then_aborts():
    driver = Driver(controller_patience=2.0)
    driver.goal()
    fail_control(driver, 1000)
    result = driver.one(PublishResult)
    assert result.status is Status.ABORTED
    assert result.text == "Failed to find a valid control. Even after executing recovery behaviors."


def test_valid_velocity_resets_the_recovery_sequence():
    driver = Driver(controller_patience=0.3)
    recovered = []
    driver.goal()
    for _ in range(6):
        for _ in range(100):
            driver.tick()
            for order in driver.of(RequestPlan):
                driver.feed(PlanSucceeded(driver.now, order.number, PLAN))
                driver.tick()
            if driver.of(ComputeVelocity):
                driver.feed(ControlFailed(driver.now))
            if driver.of(Recover):
                recovered.append(driver.one(Recover).index)
                driver.feed(RecoveryEnded(driver.now))
                break
        for _ in range(30):
            driver.tick()
            for order in driver.of(RequestPlan):
                driver.feed(PlanSucceeded(driver.now, order.number, PLAN))
            if driver.of(ComputeVelocity):
                driver.feed(VelocityComputed(driver.now, Velocity(0.1, 0)))
                break
    assert recovered == [0] * 6


def test_robot_moving_back_and_forth_oscillates():
    driver = Driver(oscillation_timeout=3.0, oscillation_distance=0.5, recovery_behavior_enabled=False)
    driver.to_controlling()
    for cycle in range(100):
        driver.tick(Pose2D(0.2 * (cycle % 2), 0, 0))
        if driver.machine.goals.active is None:
            break
        driver.feed(VelocityComputed(driver.now, Velocity(0.2, 0.0)))
    result = driver.one(PublishResult)
    assert result.text == "Robot is oscillating. Even after executing recovery behaviors."


def test_robot_making_progress_does_not_oscillate():
    driver = Driver(oscillation_timeout=3.0, oscillation_distance=0.5, recovery_behavior_enabled=False)
    driver.to_controlling()
    for cycle in range(100):
        driver.tick(Pose2D(0.05 * cycle, 0, 0))
    assert driver.status() is Status.ACTIVE


def test_plan_not_renewed_within_patience_is_abandoned():
    driver = Driver(planner_frequency=1.0, planner_patience=3.0)
    driver.to_controlling()
    began = driver.now
    for _ in range(100):
        driver.tick()
        if driver.of(ComputeVelocity) and not driver.of(RequestPlan):
            driver.feed(VelocityComputed(driver.now, Velocity(0.1, 0.0)))
        if driver.of(RequestPlan):
            driver.fail_plan()
        if driver.machine.state is GoalPhase.CLEARING:
            break
    assert driver.of(StopBase)
    assert 3.0 < driver.now - began < 4.5
    assert "no way" in driver.text


# -- deferred plans ----------------------------------------------------------------------------------------------------


def defer(driver: Driver, seconds: float) -> None:
    """Let every plan be a detour that the robot should not take yet."""
    began = driver.now
    while driver.now < began + seconds:
        driver.tick()
        for order in driver.of(RequestPlan):
            driver.feed(PlanDeferred(driver.now, order.number, "the way is blocked"))


def test_deferred_plan_stops_the_robot_and_is_requested_again():
    driver = Driver(planner_frequency=1.0)
    driver.to_controlling()
    driver.tick()
    driver.feed(VelocityComputed(driver.now, Velocity(0.5, 0.0)))
    driver.tick(seconds=1.0)
    driver.feed(PlanDeferred(driver.now, driver.one(RequestPlan).number, "the way is blocked"))
    driver.tick()
    assert driver.of(StopBase)
    assert driver.of(PublishStatus)
    assert driver.text == "waiting: the way is blocked"
    driver.tick(seconds=1.0)
    driver.feed(PlanSucceeded(driver.now, driver.one(RequestPlan).number, PLAN))
    driver.tick()
    assert driver.of(ComputeVelocity)
    assert driver.text == "controlling: the plan was computed"


def test_waiting_for_a_deferred_plan_uses_no_patience():
    driver = Driver(planner_frequency=1.0, planner_patience=2.0, controller_patience=5.0)
    driver.to_controlling()
    defer(driver, 30.0)
    assert driver.machine.state is GoalPhase.PLANNING
    driver.tick(seconds=1.0)
    driver.fail_plan()
    assert driver.machine.state is GoalPhase.PLANNING
    driver.tick(seconds=1.0)
    driver.feed(PlanSucceeded(driver.now, driver.one(RequestPlan).number, PLAN))
    driver.feed(ControlFailed(driver.now))
    assert driver.machine.state is GoalPhase.PLANNING


def test_robot_waiting_for_a_deferred_plan_does_not_oscillate():
    driver = Driver(planner_frequency=1.0, oscillation_timeout=3.0, recovery_behavior_enabled=False)
    driver.to_controlling()
    defer(driver, 10.0)
    driver.tick(seconds=1.0)
    driver.feed(PlanSucceeded(driver.now, driver.one(RequestPlan).number, PLAN))
    driver.tick()
    assert driver.of(ComputeVelocity)


def test_deferred_plan_of_the_previous_goal_is_ignored():
    driver = Driver()
    number = driver.to_planning()
    driver.goal("b")
    assert driver.feed(PlanDeferred(driver.now, number, "the way is blocked")) == []
    driver.tick()
    assert driver.text == "planning"


# -- recovery ----------------------------------------------------------------------------------------------------------


def test_recoveries_run_in_move_base_order_and_are_published():
    driver = Driver(planner_patience=0.2)
    driver.to_planning()
    driver.fail_plan()
    names = []
    for _ in range(4000):
        driver.tick()
        if driver.of(RequestPlan):
            driver.fail_plan()
        if driver.machine.goals.active is None:
            break
        if driver.of(Recover):
            names.append(driver.text)
            driver.feed(RecoveryEnded(driver.now))
    order = ("conservative_reset", "rotate_recovery", "aggressive_reset", "rotate_recovery")
    assert names == [f"recovering by {name}: no way" for name in order]


def recovering(**parameters) -> Driver:
    driver = Driver(planner_frequency=0.0, max_planning_retries=0, **parameters)
    driver.to_planning()
    driver.fail_plan()
    assert driver.machine.state is GoalPhase.CLEARING
    return driver


def test_recovery_begins_once_and_runs_each_cycle_until_it_ends():
    driver = recovering()
    assert driver.of(StopBase)
    places = [Pose2D(0.1 * cycle, 0, 0) for cycle in range(3)]
    for cycle, pose in enumerate(places):
        driver.tick(pose)
        assert driver.one(Recover) == Recover(0, pose, begin=cycle == 0)
        driver.feed(RecoveryStepped(driver.now, Velocity(-0.1, 0.0)))
        assert driver.orders == [SendVelocity(Velocity(-0.1, 0.0))]
    driver.tick()
    driver.feed(RecoveryEnded(driver.now))
    assert driver.of(StopBase)
    driver.tick()
    assert driver.of(RequestPlan)


def test_failed_recovery_states_the_reason_and_the_next_is_tried():
    driver = recovering()
    driver.tick()
    driver.feed(RecoveryEnded(driver.now, "no room behind"))
    assert driver.of(PublishStatus)
    assert driver.text == "conservative_reset failed: no room behind"
    driver.tick()
    driver.fail_plan()
    driver.tick()
    assert driver.one(Recover).index == 1


def test_recovery_interrupted_by_a_new_goal_restarts():
    driver = recovering()
    driver.tick()
    driver.feed(RecoveryStepped(driver.now, Velocity(0.0, 1.0)))
    driver.goal("b")
    assert driver.feed(RecoveryStepped(driver.now, Velocity(0.0, 1.0))) == []
    driver.tick()
    driver.fail_plan()
    driver.tick()
    assert driver.one(Recover).begin


def test_plan_after_recovery_resets_the_recovery_sequence():
    driver = Driver(planner_frequency=0.0, max_planning_retries=0)
    for _ in range(3):
        if driver.machine.goals.active is None:
            driver.to_planning()
        else:
            driver.feed(ControlFailed(driver.now))
            driver.tick()
        driver.fail_plan()
        driver.tick()
        assert driver.one(Recover).index == 0
        driver.feed(RecoveryEnded(driver.now))
        driver.tick()
        driver.feed(PlanSucceeded(driver.now, driver.one(RequestPlan).number, PLAN))


def test_motion_of_a_recovery_is_not_progress():
    driver = Driver(oscillation_timeout=3.0, oscillation_distance=0.5)
    driver.to_controlling()
    indices, x = [], 0.0
    for _ in range(300):
        x -= 0.6 if driver.machine.state is GoalPhase.CLEARING else 0.0
        driver.tick(Pose2D(x, 0, 0))
        for order in driver.of(RequestPlan):
            driver.feed(PlanSucceeded(driver.now, order.number, PLAN))
        for order in driver.of(Recover):
            indices += [order.index] if order.begin else []
            driver.feed(RecoveryEnded(driver.now) if not order.begin else RecoveryStepped(driver.now, Velocity()))
        if driver.machine.goals.active is None:
            break
    assert indices == [0, 1, 2, 3]


# -- an unknown pose ---------------------------------------------------------------------------------------------------


def test_unknown_pose_stops_the_robot_with_the_reason():
    driver = Driver()
    driver.to_controlling()
    driver.tick()
    driver.feed(VelocityComputed(driver.now, Velocity(0.5, 0)))
    driver.tick(None, reason="no odometry for 1.2 s")
    assert driver.of(StopBase)
    assert driver.of(PublishStatus)
    assert driver.text == "waiting: no odometry for 1.2 s"
    driver.tick(None, reason="no odometry for 1.2 s")
    assert driver.orders == []


def test_waiting_for_the_pose_uses_no_patience():
    driver = Driver(planner_frequency=0.0)
    driver.goal()
    for _ in range(100):
        driver.tick(None, seconds=1.0, reason="no localization yet")
    driver.tick()
    driver.fail_plan()
    assert driver.machine.state is GoalPhase.PLANNING
    driver.tick()
    assert driver.of(RequestPlan)


def test_robot_continues_when_the_pose_is_known_again():
    driver = Driver()
    driver.to_controlling()
    driver.tick(None, reason="no odometry for 1.2 s")
    driver.tick()
    assert driver.of(ComputeVelocity)
    assert driver.text == "controlling: the plan was computed"


def test_the_first_place_counts_as_left():
    watch = Oscillation(0.5, 10.0)
    assert watch.has_left(0.0, Pose2D(0, 0, 0))
    assert not watch.has_left(1.0, Pose2D(0.4, 0, 0))


def test_distance_is_measured_from_the_last_place_left():
    watch = Oscillation(0.5, 10.0)
    watch.has_left(0.0, Pose2D(0, 0, 0))
    assert not watch.has_left(1.0, Pose2D(0.3, 0, 0))
    assert watch.has_left(2.0, Pose2D(0.6, 0, 0))


def test_turning_does_not_count_as_leaving():
    watch = Oscillation(0.5, 10.0)
    watch.has_left(0.0, Pose2D(0, 0, 0))
    assert not watch.has_left(1.0, Pose2D(0, 0, 3))


def test_timeout_applies_only_if_positive():
    watch, never = Oscillation(0.5, 10.0), Oscillation(0.5, 0.0)
    for each in (watch, never):
        each.has_left(0.0, Pose2D(0, 0, 0))
    assert not watch.timed_out(10.0)
    assert watch.timed_out(10.1)
    assert not never.timed_out(1e9)
    watch.reset(10.0)
    assert not watch.timed_out(20.0)


OWN = (RecoveryBehavior("back", "back_up"), RecoveryBehavior("rest", "wait"))


@pytest.mark.parametrize(
    ("parameters", "names"),
    [
        ({}, ["conservative_reset", "rotate_recovery", "aggressive_reset", "rotate_recovery"]),
        ({"clearing_rotation_allowed": False}, ["conservative_reset", "aggressive_reset"]),
        ({"recovery_behavior_enabled": False}, []),
        ({"recovery_behaviors": OWN}, ["back", "rest"]),
        ({"recovery_behaviors": OWN, "clearing_rotation_allowed": False}, ["back", "rest"]),
        ({"recovery_behaviors": OWN, "recovery_behavior_enabled": False}, []),
        ({"recovery_behaviors": ()}, []),
    ],
)
def test_recovery_behaviors_are_the_given_ones_or_move_base_defaults(parameters, names):
    assert [each.name for each in recovery_behaviors(MoveBaseParameters(**parameters))] == names


def test_move_base_presets_only_its_own_behaviours():
    own = recovery_defaults(MoveBaseParameters(conservative_reset_dist=2.0))
    assert own == {"conservative_reset": {"reset_distance": 2.0}, "aggressive_reset": {"reset_distance": 0.0}}
    assert recovery_defaults(MoveBaseParameters(recovery_behaviors=OWN)) == {}
