"""Journeys after a ride: scans confirm the floor, show another one, or leave it open."""

import math
from typing import Any

import pytest

from ppaas.buildings.journeys.journey import LIKELY, LOOKS, TRIES, JourneyMachine
from ppaas.buildings.journeys.records import (
    AskForLift,
    CancelGoal,
    ChangeFloor,
    EnteredCar,
    FindLegs,
    Journey,
    Keep,
    LeftCar,
    LookForFloor,
    SendGoal,
)
from ppaas.buildings.lifts.states import Alight, Board
from tests.unit.ppaas.buildings.journeys.test_journey import (
    GOAL,
    LAYOUT,
    aboard,
    begun,
    goals,
    legs_from,
    out_at,
    reach,
    wait_at,
)


def leaving() -> JourneyMachine:
    """Return a journey whose robot leaves the car, on floor L3 by the word of the lift."""
    machine = aboard()
    machine.doors_closed("L3")
    machine.on_floor("L3")
    assert machine.obey(Alight("tb1", "north", "L3"), 5.0)[-1] == LookForFloor()
    return machine


def looking() -> JourneyMachine:
    """Return a journey whose robot has left the car before its scans have shown where it is."""
    machine = leaving()
    assert reach(machine) == [LeftCar(), Keep(machine.journey)]
    assert machine.journey.phase == "looking" and not machine.journey.is_aboard
    return machine


def test_a_robot_that_has_left_waits_until_its_scans_confirm_the_floor() -> None:
    machine = looking()
    assert machine.obey(Alight("tb1", "north", "L2"), 6.0) == [], "it is out"
    assert goals(machine.looked("L3", True, 1.0, out_at("L3"), 7.0)) == [SendGoal("j1/4", GOAL)]
    assert machine.looked("L2", True, 1.0, out_at("L2"), 8.0) == [], "too late"


def test_floors_that_look_alike_are_told_apart_by_the_word_of_the_lift() -> None:
    machine = looking()
    assert goals(machine.looked("L3", False, LIKELY, out_at("L3"), 7.0)) == [SendGoal("j1/4", GOAL)]


def test_a_robot_without_maps_to_compare_with_believes_the_lift() -> None:
    machine = looking()
    assert goals(machine.cannot_look(7.0)) == [SendGoal("j1/4", GOAL)]
    assert machine.cannot_look(8.0) == []


def test_a_robot_whose_scans_show_another_floor_leaves_the_car_there_and_plans_again() -> None:
    machine = leaving()
    cancel, kept, change = machine.looked("L2", True, 1.0, (11.1, 1.5, 1.6), 6.0)
    assert (cancel, change) == (CancelGoal("j1/3"), ChangeFloor("L2", (11.1, 1.5, 1.6)))
    assert isinstance(kept, Keep) and kept.journey.text == "it is on floor 'L2', not on 'L3'"
    assert machine.obey(Alight("tb1", "north", "L3"), 6.1) == [], "the lift goes on to lie"
    again = JourneyMachine(machine.journey, LAYOUT).resume()
    assert again[:2] == [AskForLift("north", "L1", "L3"), EnteredCar()] and isinstance(again[2], ChangeFloor)
    assert machine.on_floor("L2")[-1] == SendGoal("j1/4", out_at("L2")), "without another look"
    left, _, find = reach(machine)
    assert (left, find) == (LeftCar(), FindLegs(1))
    assert goals(machine.planned(1, legs_from("L2"), 7.0)) == [SendGoal("j1/5", wait_at("L2"))]


@pytest.mark.parametrize("killed", [False, True])
def test_a_robot_that_is_out_on_another_floor_goes_on_from_there(killed: bool) -> None:
    machine = looking()
    machine.seen_at("L3", out_at("L3"), 6.0)
    [_, kept, change] = machine.looked("L2", True, 1.0, (11.0, 3.0, 1.6), 6.0)
    assert change == ChangeFloor("L2", (11.0, 3.0, 1.6))
    if killed:
        machine = JourneyMachine(machine.journey, LAYOUT)
        [again] = machine.resume()
        assert isinstance(again, ChangeFloor) and again.pose == pytest.approx(out_at("L2"))
    assert goals(machine.on_floor("L2")) == [SendGoal("j1/4", out_at("L2"))]
    for _ in range(TRIES - 1):
        assert goals(machine.goal_ended(machine.journey.goal_id, False, "blocked", 7.0))
    assert reach(machine)[-1] == FindLegs(1) and machine.journey.on == "L2"
    assert isinstance(kept, Keep)


def test_the_scans_may_show_that_the_lift_has_gone_to_the_right_floor_after_all() -> None:
    machine = aboard()
    machine.doors_closed("L3")
    machine.on_floor("L3")
    machine.obey(Alight("tb1", "north", "L2"), 5.0)
    machine.on_floor("L2")
    machine.looked("L3", True, 1.0, out_at("L3"), 6.0)
    machine.on_floor("L3")
    assert goals(reach(machine)) == [SendGoal(machine.journey.goal_id, GOAL)], "no plan is needed"


def test_a_robot_on_a_floor_that_is_not_known_looks_round_and_then_waits_for_help() -> None:
    machine = looking()
    machine.seen_at("L3", (21.0, 3.0, 0.0), 6.0)
    for turn in range(LOOKS):
        kept, sent, look = machine.looked("L2", False, 0.6, out_at("L2"), 7.0)
        assert (sent, look) == (SendGoal(f"j1/{turn + 4}", pytest.approx((21.0, 3.0, math.pi / 2))), LookForFloor())
        assert "is not known: it looks round" in machine.journey.text and isinstance(kept, Keep)
        assert reach(machine) == [], "the answer decides, not the goal"
    assert machine.looked("L2", False, 0.6, out_at("L2"), 8.0) == [Keep(machine.journey), LookForFloor()]
    assert "it waits" in machine.journey.text
    assert JourneyMachine(machine.journey, LAYOUT).resume()[-1] == LookForFloor()
    assert machine.cancel(9.0)[0] == CancelGoal(machine.journey.goal_id) and machine.is_over


def test_a_robot_that_drives_out_looks_again_meanwhile() -> None:
    machine = leaving()
    assert machine.looked("L2", False, 0.6, out_at("L2"), 6.0) == [LookForFloor()]
    assert machine.looked("L3", False, 0.5, out_at("L3"), 6.0) == [LookForFloor()]


def test_a_robot_that_never_rode_does_not_look() -> None:
    machine = begun()
    reach(machine)
    machine.obey(Board("tb1", "north", "L1"), 3.0)
    assert LookForFloor() not in machine.obey(Alight("tb1", "north", "L1"), 4.0)
    assert reach(machine)[0] == LeftCar() and machine.journey.phase == "planning"


def test_what_a_ride_has_shown_is_forgotten_with_the_next_one() -> None:
    machine = aboard()
    assert machine.measured(99_000.0, 4.0) == [Keep(machine.journey)]
    assert (machine.journey.pressure, machine.journey.pressure_at) == (99_000.0, 4.0)
    machine.doors_closed("L3")
    machine.on_floor("L3")
    machine.obey(Alight("tb1", "north", "L3"), 5.0)
    assert machine.measured(98_000.0, 6.0) == [], "it is on its way out"
    machine.looked("L2", True, 1.0, (11.0, 1.5, 1.6), 6.0)
    machine.on_floor("L2")
    reach(machine)
    machine.planned(1, legs_from("L2"), 7.0)
    reach(machine)
    fresh: dict[str, Any] = {name: getattr(machine.journey, name) for name in ("found", "lied", "looks", "pressure")}
    assert fresh == {"found": "", "lied": "", "looks": 0, "pressure": 0.0}
    assert isinstance(machine.journey, Journey) and machine.journey.phase == "waiting"
