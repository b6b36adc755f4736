"""A charger that fails a robot, or lies to it, is left for another one, with the reason; the robot comes back later."""

from typing import Any

import pytest

from ppaas.energy.battery import Battery
from ppaas.energy.sites import Sites
from ppaas.tasks.chargers import RISE, SHUNNED_FOR, STALLED
from ppaas.tasks.charging import ALMOST_FULL
from ppaas.tasks.dispatcher import Dispatcher
from ppaas.tasks.orders import Order, RobotNow, Send, StoreTask
from ppaas.tasks.records import Place, Task

NEAR: Place = (1.0, 0.0, 0.0)
FAR: Place = (50.0, 0.0, 0.0)
SITES = Sites({"near": NEAR, "far": FAR}, docks={"near": "near"})


def robot(charge: float, place: Place = (0.0, 0.0, 0.0)) -> RobotNow:
    return RobotNow(place, battery=Battery(charge))


def led(charge: float = 0.2) -> Dispatcher:
    dispatcher = Dispatcher([], 0.0)
    dispatcher.sites = SITES
    dispatcher.see({"r": robot(charge)}, 0.0)
    return dispatcher


def sent(orders: list[Order]) -> list[tuple[Place, str]]:
    return [(order.place, order.dock) for order in orders if isinstance(order, Send)]


def stored(orders: list[Order]) -> list[Task]:
    return [order.task for order in orders if isinstance(order, StoreTask)]


def trip_of(dispatcher: Dispatcher) -> Task:
    [trip] = dispatcher.tasks.values()
    return trip


def at_charger(charge: float = 0.2, **sites: Any) -> Dispatcher:
    dispatcher = led(charge)
    dispatcher.decide(0.0)
    dispatcher.goal_ended("r", trip_of(dispatcher).goal_id, "succeeded", "", 1.0)
    return dispatcher


def test_a_trip_to_a_dock_ends_by_docking_and_one_to_a_station_does_not() -> None:
    dispatcher = led()
    assert sent(dispatcher.decide(0.0)) == [(NEAR, "near")]
    trip = trip_of(dispatcher)
    assert trip.dock == "near"
    again = Dispatcher([trip], 1.0)
    again.sites = SITES
    assert sent(again.see({"r": robot(0.2)}, 1.0)) == [(NEAR, "near")]
    dispatcher.goal_ended("r", trip.goal_id, "aborted", "contact-without-charge", 2.0)
    assert sent(dispatcher.decide(3.0)) == [(FAR, "")]


def test_a_charger_that_fails_a_robot_is_shunned_for_a_while_and_the_reason_is_stored() -> None:
    dispatcher = led()
    dispatcher.decide(0.0)
    [failed] = stored(dispatcher.goal_ended("r", trip_of(dispatcher).goal_id, "aborted", "charger-lies: no", 2.0))
    assert failed.state == "failed" and "charger-lies" in failed.reason
    dispatcher.decide(3.0)
    dispatcher.goal_ended("r", trip_of(dispatcher).goal_id, "aborted", "dock-not-seen", 4.0)
    assert dispatcher.tasks == {}
    assert dispatcher.decide(5.0) == [], "both have failed: it does not try them in turns"
    assert sent(dispatcher.decide(2.0 + SHUNNED_FOR)) == [(NEAR, "near")]


def test_another_robot_may_use_a_charger_that_failed_one() -> None:
    dispatcher = led()
    dispatcher.decide(0.0)
    dispatcher.goal_ended("r", trip_of(dispatcher).goal_id, "aborted", "dock-not-reached", 2.0)
    dispatcher.see({"r": robot(0.2), "s": robot(0.15)}, 3.0)
    assert sorted(sent(dispatcher.decide(3.0))) == [(NEAR, "near"), (FAR, "")]


@pytest.mark.parametrize("noise", [0.0, 0.4 * RISE])
def test_a_charger_that_lies_is_left_for_the_next_one(noise: float) -> None:
    dispatcher = at_charger()
    for number in range(8):
        now = 1.0 + number * STALLED / 8.0
        dispatcher.see({"r": robot(0.2 + noise * (number % 2))}, now)
        assert dispatcher.decide(now) == []
    dispatcher.see({"r": robot(0.2)}, 1.0 + STALLED)
    orders = dispatcher.decide(1.0 + STALLED)
    assert "not charged there: its battery stays at 20%" in stored(orders)[0].reason
    assert (stored(orders)[0].state, sent(orders)) == ("failed", [(FAR, "")])


def test_a_robot_stays_at_a_slow_charger() -> None:
    dispatcher = at_charger()
    for number in range(20):
        now = 1.0 + 0.9 * number * STALLED
        dispatcher.see({"r": robot(0.2 + number * RISE)}, now)
        dispatcher.decide(now)
    assert trip_of(dispatcher).holding == 1.0


def test_an_old_battery_that_never_gets_full_is_full() -> None:
    dispatcher = at_charger()
    for now in (1.0, 1.0 + STALLED):
        dispatcher.see({"r": robot(ALMOST_FULL + 0.02)}, now)
        orders = dispatcher.decide(now)
    assert [task.state for task in stored(orders)] == ["done"]
