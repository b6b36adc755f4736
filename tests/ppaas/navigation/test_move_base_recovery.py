"""Move Base, transition by transition: control, recovery, and a pose that is not known."""

import math

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.navigation.events import (
    ControlFailed,
    CostmapCleared,
    PlanSucceeded,
    VelocityComputed,
)
from ppaas.navigation.move_base import State
from ppaas.navigation.orders import (
    ClearCostmap,
    ComputeVelocity,
    PublishResult,
    PublishStatus,
    RequestPlan,
    SendVelocity,
    Stop,
)
from tests.support.move_base_driver import PLAN, Driver

# -- control -----------------------------------------------------------------------------------------------------------


def test_when_no_velocity_is_free_it_stops_and_plans_anew():
    driver = Driver()
    driver.to_controlling()
    driver.tick()
    driver.feed(ControlFailed(driver.now))
    assert driver.of(Stop)
    assert driver.machine.state is State.PLANNING
    driver.tick()
    assert driver.of(RequestPlan)


def fail_control(driver: Driver, cycles: int) -> None:
    """Plans are found, velocities never."""
    for _ in range(cycles):
        driver.tick()
        for order in driver.of(RequestPlan):
            driver.feed(PlanSucceeded(driver.now, order.number, PLAN))
            driver.tick()
        if driver.of(ComputeVelocity):
            driver.feed(ControlFailed(driver.now))
        for _ in driver.of(ClearCostmap):
            driver.feed(CostmapCleared(driver.now))
        if driver.machine.goals.active is None:
            return


def test_when_control_fails_for_longer_than_its_patience_recovery_begins_and_at_last_it_is_aborted():
    driver = Driver(controller_patience=2.0, rotation_patience=0.5)
    driver.goal()
    fail_control(driver, 1000)
    result = driver.one(PublishResult)
    assert result.status is Status.ABORTED
    assert result.text == "Failed to find a valid control. Even after executing recovery behaviors."


def test_a_velocity_that_is_found_makes_recovery_begin_from_the_first_again():
    driver = Driver(controller_patience=0.3, rotation_patience=0.1)
    cleared = []
    driver.goal()
    for _ in range(6):
        for _ in range(100):
            driver.tick()
            for order in driver.of(RequestPlan):
                driver.feed(PlanSucceeded(driver.now, order.number, PLAN))
                driver.tick()
            if driver.of(ComputeVelocity):
                driver.feed(ControlFailed(driver.now))
            if driver.of(ClearCostmap):
                cleared.append(driver.one(ClearCostmap).beyond)
                driver.feed(CostmapCleared(driver.now))
                break
        for _ in range(30):
            driver.tick()
            for order in driver.of(RequestPlan):
                driver.feed(PlanSucceeded(driver.now, order.number, PLAN))
            if driver.of(ComputeVelocity):
                driver.feed(VelocityComputed(driver.now, Velocity(0.1, 0)))
                break
    assert cleared == [3.0] * 6


def test_a_robot_that_goes_to_and_fro_oscillates():
    driver = Driver(oscillation_timeout=3.0, oscillation_distance=0.5, recovery_behavior_enabled=False)
    driver.to_controlling()
    for cycle in range(100):
        driver.tick(Pose2D(0.2 * (cycle % 2), 0, 0))
        if driver.machine.goals.active is None:
            break
        driver.feed(VelocityComputed(driver.now, Velocity(0.2, 0.0)))
    result = driver.one(PublishResult)
    assert result.text == "Robot is oscillating. Even after executing recovery behaviors."


def test_a_robot_that_gets_on_does_not_oscillate():
    driver = Driver(oscillation_timeout=3.0, oscillation_distance=0.5, recovery_behavior_enabled=False)
    driver.to_controlling()
    for cycle in range(100):
        driver.tick(Pose2D(0.05 * cycle, 0, 0))
    assert driver.status() is Status.ACTIVE


def test_a_plan_that_cannot_be_renewed_for_longer_than_patience_is_given_up():
    driver = Driver(planner_frequency=1.0, planner_patience=3.0)
    driver.to_controlling()
    began = driver.now
    for _ in range(100):
        driver.tick()
        if driver.of(ComputeVelocity) and not driver.of(RequestPlan):
            driver.feed(VelocityComputed(driver.now, Velocity(0.1, 0.0)))
        if driver.of(RequestPlan):
            driver.fail_plan()
        if driver.machine.state is State.CLEARING:
            break
    assert driver.of(Stop)
    assert 3.0 < driver.now - began < 4.5
    assert "no way" in driver.text


# -- recovery ----------------------------------------------------------------------------------------------------------


def test_recoveries_come_in_the_order_of_move_base():
    driver = Driver(planner_patience=0.2)
    driver.to_planning()
    driver.fail_plan()
    names = []
    for _ in range(4000):
        driver.tick(Pose2D(0, 0, 0.1 * len(names)))
        if driver.of(RequestPlan):
            driver.fail_plan()
        if driver.machine.goals.active is None:
            break
        if "recovering by" in driver.text:
            name = driver.text.split()[2].rstrip(":")
            if not names or names[-1] != name:
                names.append(name)
        if driver.of(ClearCostmap):
            driver.feed(CostmapCleared(driver.now))
    assert names == ["conservative_reset", "rotate_recovery", "aggressive_reset", "rotate_recovery"]


def test_the_robot_turns_once_round_and_then_plans_anew():
    driver = Driver(planner_patience=0.0, max_planning_retries=0)
    driver.to_planning()
    driver.fail_plan()
    driver.feed(CostmapCleared(driver.now))
    driver.tick()
    driver.fail_plan()
    assert driver.machine.state is State.CLEARING
    turned, heading = 0.0, 0.0
    while driver.machine.state is State.CLEARING:
        driver.tick(Pose2D(0, 0, math.remainder(heading, 2 * math.pi)))
        for order in driver.of(SendVelocity):
            assert 0.4 <= order.velocity.angular <= 1.0
            assert order.velocity.linear == 0.0
            heading += 0.1 * order.velocity.angular
            turned = heading
    assert 2 * math.pi <= turned < 2 * math.pi + 0.2
    assert driver.of(Stop)
    driver.tick()
    assert driver.of(RequestPlan)


def test_a_plan_after_recovery_makes_the_next_recovery_begin_from_the_first():
    driver = Driver(planner_frequency=0.0, max_planning_retries=0)
    for _ in range(3):
        if driver.machine.goals.active is None:
            driver.to_planning()
        else:
            driver.feed(ControlFailed(driver.now))
            driver.tick()
        driver.fail_plan()
        assert driver.one(ClearCostmap).beyond == 3.0
        driver.feed(CostmapCleared(driver.now))
        driver.tick()
        driver.feed(PlanSucceeded(driver.now, driver.one(RequestPlan).number, PLAN))


# -- an unknown pose ---------------------------------------------------------------------------------------------------


def test_while_the_pose_is_not_known_it_stands_and_says_why():
    driver = Driver()
    driver.to_controlling()
    driver.tick()
    driver.feed(VelocityComputed(driver.now, Velocity(0.5, 0)))
    driver.tick(None, reason="no odometry for 1.2 s")
    assert driver.of(Stop)
    assert driver.of(PublishStatus)
    assert driver.text == "waiting: no odometry for 1.2 s"
    driver.tick(None, reason="no odometry for 1.2 s")
    assert driver.orders == []


def test_waiting_for_the_pose_uses_up_no_patience():
    driver = Driver(planner_frequency=0.0)
    driver.goal()
    for _ in range(100):
        driver.tick(None, seconds=1.0, reason="no localization yet")
    driver.tick()
    driver.fail_plan()
    assert driver.machine.state is State.PLANNING
    driver.tick()
    assert driver.of(RequestPlan)


def test_when_the_pose_is_known_again_it_drives_on():
    driver = Driver()
    driver.to_controlling()
    driver.tick(None, reason="no odometry for 1.2 s")
    driver.tick()
    assert driver.of(ComputeVelocity)
    assert driver.text == "controlling"
