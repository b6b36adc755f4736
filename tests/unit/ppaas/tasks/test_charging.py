"""Robots charge in time, leave chargers for others and for tasks, park, and get no task that their charge ends."""

import math
from typing import Any

import pytest

from ppaas.energy.battery import Battery
from ppaas.energy.sites import Sites
from ppaas.tasks.charging import ALMOST_FULL, ENOUGH, FULL, LOW, OPPORTUNE, PATIENCE, must_charge
from ppaas.tasks.dispatcher import Dispatcher
from ppaas.tasks.orders import Order, RobotNow, Send, StoreTask
from ppaas.tasks.reach import RESERVE, demand_of, lasts, straight
from ppaas.tasks.records import Place, Task
from ppaas.tasks.rehearsal import Rehearsal

A, B, C = (0.0, 0.0, 0.0), (100.0, 0.0, 0.0), (200.0, 0.0, 0.0)
DOCK: Place = (0.0, 10.0, 0.0)
SPOT: Place = (50.0, 50.0, 0.0)
SITES = Sites({"dock": DOCK})


def task(name: str = "t", *places: Place, kind: str = "go_to", **fields: Any) -> Task:
    return Task(id=name, kind=kind, places=places or (B,), **fields)  # type: ignore[arg-type]


def robot(charge: float | None, place: Place = A, **fields: Any) -> RobotNow:
    return RobotNow(place, battery=None if charge is None else Battery(charge, 1e-3, 1e-5, 1e-3), **fields)


def led(*tasks: Task, sites: Sites = SITES, **robots: RobotNow) -> Dispatcher:
    dispatcher = Dispatcher(tasks, 0.0)
    dispatcher.sites = sites
    dispatcher.see(robots, 0.0)
    return dispatcher


def sent(orders: list[Order]) -> dict[str, Place]:
    return {order.robot: order.place for order in orders if isinstance(order, Send)}


def arrive(dispatcher: Dispatcher, name: str, now: float) -> None:
    [one] = [task for task in dispatcher.tasks.values() if task.robot == name]
    dispatcher.goal_ended(name, one.goal_id, "succeeded", "", now)


# -- the charge for a task ---------------------------------------------------------------------------------------------


def test_a_task_costs_its_ways_the_way_home_and_its_waits() -> None:
    battery = Battery(1.0, per_metre=1e-3, per_second=1e-4)
    there = demand_of(task("t", B, C, kind="pick_drop"), SITES).charge(50.0, battery)
    metres = 50.0 + 1.3 * (100.0 + math.hypot(200.0, 10.0))
    assert there == pytest.approx(1e-3 * metres + 1e-4 * metres / 0.5)
    endless = task("p", B, C, kind="patrol", rounds=1000)
    assert demand_of(endless, SITES).charge(0.0, battery) < 1.0
    assert lasts(demand_of(task(), SITES), 1e9, None)


def test_a_robot_gets_no_task_from_which_it_could_not_come_back() -> None:
    dispatcher = led(task("t", B), weak=robot(0.22, B), strong=robot(0.9, A))
    dispatcher.decide(0.0)
    assert dispatcher.tasks["t"].robot == "strong"
    alone = led(task("t", C, B, kind="pick_drop"), weak=robot(0.45, B))
    alone.decide(0.0)
    assert alone.tasks["t"].state == "queued"


def test_the_charge_limits_nobody_without_chargers_or_reports() -> None:
    for sites, charge in ((Sites(), 0.01), (SITES, None)):
        dispatcher = led(task("t", C), sites=sites, r=robot(charge))
        dispatcher.decide(0.0)
        assert dispatcher.tasks["t"].robot == "r"


def test_a_task_for_which_no_battery_lasts_says_so_before_it_starts() -> None:
    far = (3000.0, 0.0, 0.0)
    dispatcher = led(task("t", far), r=robot(1.0))
    [told] = [one.task for one in dispatcher.decide(0.0) if isinstance(one, StoreTask) and one.task.id == "t"]
    assert (told.state, "no battery lasts" in told.reason) == ("queued", True)
    assert dispatcher.decide(1.0) == []
    dispatcher.see({"r": robot(1.0), "better": RobotNow(A, battery=Battery(1.0, 1e-5, 1e-6))}, 2.0)
    dispatcher.decide(2.0)
    assert (dispatcher.tasks["t"].robot, dispatcher.tasks["t"].reason) == ("better", "")


# -- trips to chargers -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("charge", "doing", "must"),
    [
        (LOW - 0.01, None, True),
        (LOW + 0.01, None, False),
        (RESERVE + 0.02, task(state="assigned", robot="r"), True),
        (LOW - 0.01, task(state="assigned", robot="r"), False),
        (0.3, task("p", B, C, kind="patrol", state="active", robot="r", leg=1), True),
        (0.7, task("p", B, C, kind="patrol", state="active", robot="r", leg=1), False),
        (0.11, task("p", B, C, kind="pick_drop", state="active", robot="r", leg=1), False),
        (0.11, task("c", DOCK, trip="charge", state="assigned", robot="r"), False),
    ],
)
def test_a_robot_goes_to_a_charger_in_time_unless_it_carries_something(
    charge: float, doing: Task | None, must: bool
) -> None:
    assert must_charge(robot(charge), doing, SITES) is must
    assert not must_charge(robot(charge), doing, Sites())
    assert not must_charge(robot(None), doing, SITES)


def test_a_trip_to_a_charger_is_a_stored_task_that_goes_on_after_a_restart() -> None:
    dispatcher = led(r=robot(0.2))
    orders = dispatcher.decide(5.0)
    assert [type(order) for order in orders] == [StoreTask, Send]
    assert sent(orders) == {"r": DOCK}
    [trip] = dispatcher.tasks.values()
    assert (trip.trip, trip.state, trip.named_robot) == ("charge", "assigned", "r")
    again = Dispatcher([trip], 6.0)
    again.sites = SITES
    assert [order.goal_id for order in again.see({"r": robot(0.2)}, 6.0) if isinstance(order, Send)] == [trip.goal_id]
    arrive(again, "r", 7.0)
    assert again.release(8.0) == again.decide(8.0) == []
    again.see({"r": robot(FULL, DOCK)}, 9.0)
    [done] = [order.task for order in again.release(9.0) if isinstance(order, StoreTask)]
    assert (done.id, done.state) == (trip.id, "done")


def test_the_lowest_robots_charge_first_and_the_others_wait() -> None:
    dispatcher = led(low=robot(0.2), lower=robot(0.18), lowest=robot(0.15))
    assert sent(dispatcher.decide(0.0)) == {"lowest": DOCK}
    assert dispatcher.decide(1.0) == []


def test_a_charger_at_which_a_full_robot_stands_comes_last() -> None:
    sites = Sites({"near": A, "far": B, "farther": C})
    dispatcher = led(sites=sites, full=robot(FULL, A), low=robot(0.2, A), lower=robot(0.19, (1.0, 1.0, 0.0)))
    assert sent(dispatcher.decide(0.0)) == {"lower": B, "low": C}
    alone = led(sites=Sites({"only": A}), full=robot(FULL, A), low=robot(0.2, B))
    assert sent(alone.decide(0.0)) == {"low": A}
    there = led(sites=sites, low=robot(0.2, A))
    assert sent(there.decide(0.0)) == {"low": A}


def test_robots_without_anything_to_do_charge_at_free_chargers() -> None:
    assert sent(led(r=robot(OPPORTUNE - 0.01)).decide(0.0)) == {"r": DOCK}
    assert led(r=robot(OPPORTUNE + 0.01)).decide(0.0) == []
    busy = led(task("t", A), r=robot(OPPORTUNE - 0.01))
    busy.decide(0.0)
    assert busy.tasks["t"].robot == "r"


@pytest.mark.parametrize(("charge", "waited", "charges"), [(0.5, 0.0, False), (0.5, PATIENCE, True), (0.3, 0.0, True)])
def test_a_robot_stays_for_a_task_that_it_could_do_soon(charge: float, waited: float, charges: bool) -> None:
    near, other = (60.0, 0.0, 0.0), task("n", (60.0, 0.0, 0.0), state="active", robot="near", begun=0.0)
    dispatcher = led(other, task("t", near), r=robot(charge, (-90.0, 0.0, 0.0)), near=robot(0.9, near))
    orders = dispatcher.decide(waited)
    assert dispatcher.tasks["t"].state == "queued", "the other robot is there sooner"
    assert sent(orders) == ({"r": DOCK} if charges else {})


def test_a_patrol_is_given_back_before_the_charge_runs_out_and_goes_on_later() -> None:
    dispatcher = led(task("p", A, B, kind="patrol", rounds=9), r=robot(0.9))
    dispatcher.decide(0.0)
    arrive(dispatcher, "r", 1.0)
    dispatcher.see({"r": robot(0.2, A)}, 2.0)
    assert sent(dispatcher.decide(2.0)) == {"r": DOCK}
    assert (dispatcher.tasks["p"].state, dispatcher.tasks["p"].leg) == ("queued", 1)
    assert "must charge" in dispatcher.tasks["p"].reason
    arrive(dispatcher, "r", 3.0)
    dispatcher.see({"r": robot(FULL, DOCK)}, 4.0)
    dispatcher.release(4.0)
    assert sent(dispatcher.decide(4.0)) == {"r": B}


@pytest.mark.parametrize(("charge", "leaves"), [(ALMOST_FULL - 0.01, False), (ALMOST_FULL + 0.01, True)])
def test_a_charger_is_left_early_for_others_that_must_charge(charge: float, leaves: bool) -> None:
    dispatcher = led(r=robot(0.2))
    dispatcher.decide(0.0)
    arrive(dispatcher, "r", 1.0)
    dispatcher.add(task("t", C), 1.0)
    dispatcher.see({"r": robot(charge, DOCK), "other": robot(0.15, SPOT)}, 2.0 + PATIENCE)
    assert sent(dispatcher.decide(2.0 + PATIENCE)) == ({"other": DOCK, "r": C} if leaves else {})


@pytest.mark.parametrize(
    ("charge", "waited", "leaves"),
    [(ENOUGH - 0.01, PATIENCE, False), (ENOUGH + 0.01, PATIENCE - 1.0, False), (ENOUGH + 0.01, PATIENCE, True)],
)
def test_a_charger_is_left_early_for_a_task_that_has_waited(charge: float, waited: float, leaves: bool) -> None:
    dispatcher = led(r=robot(0.2))
    dispatcher.decide(0.0)
    arrive(dispatcher, "r", 1.0)
    dispatcher.add(task("t", A, created=2.0), 2.0)
    dispatcher.see({"r": robot(charge, DOCK)}, 2.0 + waited)
    assert sent(dispatcher.decide(2.0 + waited)) == ({"r": A} if leaves else {})


def test_a_trip_of_a_robot_that_is_gone_ends() -> None:
    dispatcher = led(r=robot(0.2))
    dispatcher.decide(0.0)
    dispatcher.see({}, 1.0)
    dispatcher.see({"s": robot(0.2)}, 100.0)
    orders = dispatcher.decide(100.0)
    assert sent(orders) == {"s": DOCK}
    assert [one.named_robot for one in dispatcher.tasks.values()] == ["s"]


# -- parking -----------------------------------------------------------------------------------------------------------


def test_robots_without_a_task_park_and_leave_for_the_next_one() -> None:
    dispatcher = led(r=robot(None), sites=Sites({}, {"spot": SPOT}))
    assert sent(dispatcher.decide(0.0)) == {"r": SPOT}
    dispatcher.add(task("t", A), 1.0)
    assert sent(dispatcher.decide(1.0)) == {"r": A}
    assert [one.trip for one in dispatcher.tasks.values() if one.robot] == [None]
    arrive(dispatcher, "r", 2.0)
    orders = dispatcher.decide(2.0)
    assert sent(orders) == {"r": SPOT}
    arrive(dispatcher, "r", 3.0)
    dispatcher.see({"r": robot(None, SPOT)}, 4.0)
    assert dispatcher.decide(4.0) == []


def test_a_spot_has_one_robot() -> None:
    dispatcher = led(r=robot(None), s=robot(None), sites=Sites({}, {"spot": SPOT}))
    assert len(sent(dispatcher.decide(0.0))) == 1
    assert dispatcher.decide(1.0) == []
    assert led(r=robot(None), s=robot(None, SPOT), sites=Sites({}, {"spot": SPOT})).decide(0.0) == []


# -- a whole day -------------------------------------------------------------------------------------------------------


def test_two_robots_at_one_charger_work_all_day_and_none_is_stranded() -> None:
    tasks = [task(f"t{number}", A, B, kind="pick_drop") for number in range(200)]
    robots = {name: RobotNow(A, battery=Battery(charge, 2e-4, 1e-5, 3e-4)) for name, charge in (("r", 0.9), ("s", 0.3))}
    rehearsal = Rehearsal(tasks, robots, straight, 0.0, sites=Sites({"dock": DOCK}))
    rehearsal.run(86400.0)
    assert rehearsal.stranded == []
    done = [one for one in rehearsal.tasks.values() if one.state == "done"]
    assert len([one for one in done if one.kind == "pick_drop"]) == 200
    assert len([one for one in done if one.trip == "charge"]) >= 5


def test_a_trip_to_a_charger_has_what_is_known_of_the_battery_from_its_begin_to_its_end() -> None:
    dispatcher = led(r=robot(0.2))
    [trip] = [order.task for order in dispatcher.decide(0.0) if isinstance(order, StoreTask)]
    assert trip.learnt == (1e-3, 1e-5, 1e-3)
    arrive(dispatcher, "r", 1.0)
    dispatcher.see({"r": RobotNow(DOCK, battery=Battery(FULL, 2e-3, 1e-5, 3e-3))}, 2.0)
    [done] = [order.task for order in dispatcher.release(2.0) if isinstance(order, StoreTask)]
    assert done.learnt == (2e-3, 1e-5, 3e-3)
