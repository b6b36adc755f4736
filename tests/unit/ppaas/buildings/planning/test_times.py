"""Times in a building follow closed doors, lifts out of order and measured lengths."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from ppaas.buildings.building import DoorSettings, LiftSettings, WaySettings
from ppaas.buildings.planning.legs import legs_of
from ppaas.buildings.planning.network import BuildingLink, BuildingNetwork
from ppaas.buildings.planning.planner import BuildingPlanner
from ppaas.buildings.planning.times import BuildingState, BuildingTimes, Traveller
from ppaas.zones.zone import Zone
from tests.unit.ppaas.buildings.planning.random_buildings import costmap, door, gate, lift, passage, two_floors

START_POSE, GOAL_POSE = (0.1, 5.5, 0.0), (0.5, 0.5, 0.0)
START, GOAL = ("L0", 0.1, 5.5), ("L0", 5.9, 5.5)


def walled(more: Sequence[Zone] = (), **changes: object) -> BuildingPlanner:
    """Return a planner whose ground floor is cut in two by a wall at y = 4 m with a door at x = 3 to 4 m."""
    free = np.ones((24, 24), np.bool_)
    free[16] = False
    free[16, 12:16] = True
    building = two_floors([door("hall", 3.0, 4.1), *more], **changes)
    return BuildingPlanner(building.layout, {"L0": costmap(free), "L1": costmap(np.ones((24, 24), np.bool_))})


def seconds(planner: BuildingPlanner, times: BuildingTimes, start: tuple[str, float, float]) -> float:
    found = planner.plan(times, start, GOAL)
    return math.inf if found is None else found.seconds


def test_a_door_with_a_device_takes_the_time_in_which_it_opens() -> None:
    below = ("L0", 5.9, 3.0)
    plain = walled()
    slow = walled(doors=(DoorSettings(floor="L0", door="hall", opens=7.0, device="sim:"),))
    took = [seconds(planner, planner.times(Traveller()), below) for planner in (plain, slow)]
    assert took[1] == pytest.approx(took[0] + 7.0)


def test_a_closed_door_is_planned_around_and_opens_again() -> None:
    planner = walled()
    times, below = planner.times(Traveller()), ("L0", 5.9, 3.0)
    before = seconds(planner, times, below)
    planner.state.close([("L0", "hall")])
    assert seconds(planner, times, below) == math.inf
    planner.state.close([])
    assert seconds(planner, times, below) == before


@pytest.mark.parametrize(("direction", "may"), [(math.pi / 2, True), (-math.pi / 2, False), (1.0, True), (-2.0, False)])
def test_a_gate_is_passed_in_its_direction_only(direction: float, may: bool) -> None:
    planner = walled(more=[gate("hall", 3.0, 4.1, direction)])
    below = planner.times(Traveller())
    assert (seconds(planner, below, ("L0", 5.9, 3.0)) < math.inf) is may
    back = planner.plan(below, GOAL, ("L0", 5.9, 3.0))
    assert (back is not None) is not may


def test_a_lift_out_of_order_is_not_taken_until_it_is_repaired() -> None:
    planner = two_floors(lift("south", 4.0, 2.5)).planner()
    times, goal = planner.times(Traveller()), ("L1", 0.5, 0.5)
    taken = []
    for broken in ([], ["north"], ["north", "south"], []):
        planner.state.break_down(broken)
        found = planner.plan(times, START, goal)
        taken.append(found and found.chain.names)
    assert taken == [("north",), ("south",), None, ("north",)]


def test_lengths_are_bounds_until_a_floor_is_measured() -> None:
    network = BuildingNetwork(two_floors(lift("south", 4.0, 2.5)).layout)
    state = BuildingState(network, slack=[0.5, 0.5])
    times = BuildingTimes(state, Traveller(speed=0.5))
    apart = math.hypot(3.0, 1.5)
    assert times.on_floor(0)[0, 1] == pytest.approx((apart - 0.5) / 0.5, abs=1e-5)
    assert not state.measured[0]
    state.measure(0, np.array([[0.0, 9.0], [9.0, 0.0]]))
    assert times.on_floor(0)[0, 1] == pytest.approx(18.0, abs=1e-5)


@pytest.mark.parametrize(
    ("way", "traveller", "may"),
    [
        (WaySettings(way="up", kind="stairs"), Traveller(), False),
        (WaySettings(way="up", kind="stairs"), Traveller(stairs=True), True),
        (WaySettings(way="up"), Traveller(), True),
        (WaySettings(way="up", labels={"legs": "4"}), Traveller(), False),
        (WaySettings(way="up", labels={"legs": "4"}), Traveller(labels={"legs": "4", "arm": "1"}), True),
        (WaySettings(way="up"), Traveller(avoid=frozenset({"up"})), False),
    ],
)
def test_a_robot_takes_the_ways_that_it_may(way: WaySettings, traveller: Traveller, *, may: bool) -> None:
    assert traveller.may_take(BuildingLink(0, 1, "up", 0.0, 5.0, way)) is may
    planner = two_floors([passage("up", 5.0, 5.0)], ways=(way,)).planner()
    planner.state.break_down(["north"])
    found = planner.plan(planner.times(traveller), START, ("L1", 5.5, 5.5))
    assert (found is not None) is may


def test_a_one_way_ramp_is_entered_from_its_floor_alone() -> None:
    way = WaySettings(way="up", one_way="L1", length=2.0)
    planner = two_floors([passage("up", 5.0, 5.0)], ways=(way,)).planner()
    times = planner.times(Traveller())
    up = planner.plan(times, ("L0", 5.5, 5.5), ("L1", 5.5, 5.5))
    down = planner.plan(times, ("L1", 5.5, 5.5), ("L0", 5.5, 5.5))
    assert up is not None
    assert down is not None
    assert (up.chain.names, down.chain.names) == (("north",), ("up",))


def test_a_ride_waits_and_opens_doors_twice() -> None:
    settings = LiftSettings(lift="north", wait=10.0, doors=2.0, speed=2.0)
    network = BuildingNetwork(two_floors(lifts=(settings,)).layout)
    assert [link.seconds for link in network.links] == [pytest.approx(10.0 + 2 * 2.0 + 4.0 / 2.0)] * 2
    assert network.ride("north", 0, network.of_lift("north")[1]).seconds == pytest.approx(2.0 + 4.0 / 2.0)


def test_the_waits_of_now_decide_which_lift_is_taken_and_how_long_it_takes() -> None:
    planner = two_floors(lift("south", 4.0, 2.5)).planner()
    times, goal = planner.times(Traveller()), ("L1", 0.5, 0.5)
    mean = planner.plan(times, START, goal)
    assert mean is not None and mean.chain.names == ("north",)
    planner.state.expect({("north", "L0"): 50.0, ("north", "L1"): 0.0})
    found = planner.plan(times, START, goal)
    assert found is not None and found.chain.names == ("south",)
    planner.state.expect({("north", "L0"): 50.0, ("south", "L0"): math.inf})
    found = planner.plan(times, START, goal)
    assert found is not None and found.chain.names == ("north",)
    assert found.seconds == pytest.approx(mean.seconds - LiftSettings(lift="north").wait + 50.0)
    legs = legs_of(times, found.route, found.goal, (START_POSE, GOAL_POSE))
    assert sum(leg.seconds for leg in legs) == pytest.approx(found.seconds, abs=0.01)
    planner.state.expect({})
    assert planner.plan(times, START, goal).seconds == mean.seconds  # type: ignore[union-attr]


def test_a_lift_that_does_not_stop_at_a_floor_now_leads_not_there() -> None:
    planner = two_floors().planner()
    times = planner.times(Traveller())
    planner.state.expect({("north", "L1"): math.inf})
    assert planner.plan(times, START, ("L1", 0.5, 0.5)) is None
