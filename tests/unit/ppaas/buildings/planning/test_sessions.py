"""A new plan keeps a ride that a robot has begun, unless another route is clearly faster."""

import pytest

from ppaas.buildings.building import LiftSettings
from ppaas.buildings.planning.legs import legs_of
from ppaas.buildings.planning.planner import BuildingPlanner
from ppaas.buildings.planning.routes import alternatives, best_route
from ppaas.buildings.planning.sessions import Session, starts_from_car, with_begun_first, without_margin
from ppaas.buildings.planning.times import Traveller
from ppaas.errors import InvalidInput
from tests.unit.ppaas.buildings.planning.random_buildings import lift, two_floors

GOAL = ("L1", 5.0, 5.8)


def planner(north_waits: float) -> BuildingPlanner:
    """Return a planner on two floors with the lifts ``north`` and ``south``."""
    lifts = (LiftSettings(lift="north", wait=north_waits), LiftSettings(lift="south", wait=10.0))
    return two_floors(lift("south", 4.0, 2.5), lifts=lifts).planner()


@pytest.mark.parametrize(("north_waits", "first"), [(12.0, "north"), (60.0, "south")])
def test_a_robot_that_waits_for_a_lift_keeps_it_within_the_margin(north_waits: float, first: str) -> None:
    found = planner(north_waits)
    times = found.times(Traveller())
    start, goal = found.start(times, ("L0", 1.5, 3.0)), found.goal(times, GOAL)
    routes = alternatives(times, [start], goal, 2)
    assert routes[0].chain.names == ("south",)
    kept = with_begun_first(times, [start], goal, routes, Session("north", "L0"))
    assert kept[0].chain.names == (first,)
    assert {route.chain.names for route in kept} == {("north",), ("south",)}


def test_a_broken_lift_is_not_kept() -> None:
    found = planner(12.0)
    times = found.times(Traveller())
    found.state.break_down(["north"])
    start, goal = found.start(times, ("L0", 1.5, 3.0)), found.goal(times, GOAL)
    routes = alternatives(times, [start], goal, 2)
    assert with_begun_first(times, [start], goal, routes, Session("north", "L0")) == routes


def test_a_robot_in_a_car_rides_on_and_gets_out_at_the_floor_of_its_goal() -> None:
    found = planner(12.0)
    times, goal = found.times(Traveller()), None
    session = Session("north", "L0", inside=True, to="L1")
    goal = found.goal(times, GOAL)
    route = best_route(times, starts_from_car(times, session), goal)
    assert route is not None
    legs = legs_of(times, route, goal, ((0.0, 0.0, 0.0), (5.0, 5.8, 0.0)), session)
    assert [(leg.kind, leg.floor, leg.to_floor) for leg in legs] == [("lift", "L0", "L1"), ("drive", "L1", "L1")]
    assert sum(leg.seconds for leg in legs) == pytest.approx(route.seconds, abs=1e-4)
    assert legs[0].seconds == pytest.approx(3.0 + 4.0 + legs[0].length / 0.5, abs=1e-4)


def test_a_car_that_was_sent_elsewhere_costs_the_margin_in_the_choice_alone() -> None:
    found = planner(12.0)
    times = found.times(Traveller())
    session, goal = Session("north", "L0", inside=True, to="L0"), found.goal(times, GOAL)
    route = best_route(times, starts_from_car(times, session), goal)
    plain = best_route(times, starts_from_car(times, Session("north", "L0", inside=True, to="L1")), goal)
    assert route is not None
    assert plain is not None
    assert without_margin(times, route, session).seconds == pytest.approx(plain.seconds)


@pytest.mark.parametrize("session", [Session("east", "L0", inside=True), Session("north", "L7", inside=True)])
def test_a_ride_in_an_unknown_lift_or_on_an_unknown_floor_is_refused(session: Session) -> None:
    with pytest.raises(InvalidInput, match="there is no"):
        starts_from_car(planner(12.0).times(Traveller()), session)
