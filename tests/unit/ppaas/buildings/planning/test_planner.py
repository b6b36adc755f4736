"""Plans over floors are as short as those of Dijkstra's algorithm over all cells of the building."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.buildings.planning.legs import legs_of
from ppaas.buildings.planning.planner import BuildingPlanner
from ppaas.buildings.planning.times import Traveller
from ppaas.errors import InvalidBuilding, StartOccupied
from tests.reference.buildings import best_by_names, times_from
from tests.unit.ppaas.buildings.planning.random_buildings import RESOLUTION, RandomBuilding, jumps_of, shut, two_floors

TRAVELLERS = (
    Traveller(),
    Traveller(speed=1.5, stairs=True, labels={"legs": "4"}),
    Traveller(speed=0.2, avoid=frozenset({"lift 0"})),
)
SEEDS = st.integers(0, 10_000)


@given(SEEDS, st.sampled_from(TRAVELLERS))
@settings(max_examples=20, deadline=None)
def test_a_plan_takes_the_least_time(seed: int, traveller: Traveller) -> None:
    building, rng = RandomBuilding.of(seed), np.random.default_rng(seed)
    planner = building.planner()
    times = planner.times(traveller)
    doors = [(door.floor, door.door) for door in building.layout.doors if not door.lift]
    for closed in ([], doors[: len(doors) // 2 + 1], doors[1:]):
        planner.state.close(closed)
        jumps = jumps_of(planner, traveller, frozenset(closed))
        for _ in range(3):
            (own, start), (to, goal) = building.spot(rng), building.spot(rng)
            free = shut(planner)
            if not (free[own[0]][own[1:]] and free[to[0]][to[1:]]):
                continue
            expected = times_from(free, jumps, {own: 0.0}, RESOLUTION / traveller.speed).get(to, math.inf)
            found = planner.plan(times, start, goal)
            assert (math.inf if found is None else found.seconds) == pytest.approx(expected, abs=1e-4)
            assert planner.costs(times, [start], [goal])[0, 0] == pytest.approx(expected, abs=1e-4)
            if found is not None:
                legs = legs_of(times, found.route, found.goal, ((*start[1:], 0.0), (*goal[1:], 0.0)))
                assert sum(leg.seconds for leg in legs) == pytest.approx(expected, abs=1e-4)
                assert (legs[0].floor, legs[-1].to_floor) == (start[0], goal[0])
                assert all(one.goal == other.start for one, other in itertools.pairwise(legs))
                assert tuple(leg.name for leg in legs if leg.kind in ("lift", "way")) == found.chain.names


@given(SEEDS, st.sampled_from(TRAVELLERS[:2]))
@settings(max_examples=8, deadline=None)
def test_alternatives_are_the_best_by_other_lifts_and_ways(seed: int, traveller: Traveller) -> None:
    building, rng = RandomBuilding.of(seed), np.random.default_rng(seed)
    planner = building.planner()
    times = planner.times(traveller)
    (own, start), (to, goal) = building.spot(rng), building.spot(rng)
    free = shut(planner)
    if not (free[own[0]][own[1:]] and free[to[0]][to[1:]]):
        return
    jumps = jumps_of(planner, traveller, frozenset())
    expected = best_by_names(free, jumps, own, to, RESOLUTION / traveller.speed)
    found, _ = planner.alternatives(times, start, goal, 4)
    best = planner.plan(times, start, goal)
    assert bool(found) == (best is not None)
    if best is not None:
        assert found[0].seconds == pytest.approx(best.seconds, abs=1e-4)
    simple = [route for route in found if len(set(route.chain.names)) == len(route.chain.names)]
    least = sorted(expected.values())[: len(simple)]
    assert [route.seconds for route in simple] == pytest.approx(least, abs=1e-4)
    assert len({route.chain.names for route in found}) == len(found)
    assert len(found) >= min(4, len(expected))
    for route in simple:
        assert route.seconds == pytest.approx(expected[route.chain.names], abs=1e-4)


def test_paths_at_the_ends_are_on_the_floors_of_start_and_goal() -> None:
    planner = two_floors().planner()
    found = planner.plan(planner.times(Traveller()), ("L0", 0.1, 0.1), ("L1", 5.9, 5.9))
    assert found is not None
    assert found.chain.names == ("north",)
    assert found.first[0].tolist() == [0, 0]
    assert found.last[-1].tolist() == [23, 23]


def test_a_place_without_a_free_cell_and_an_unknown_floor_are_refused() -> None:
    planner = RandomBuilding.of(1).planner()
    times = planner.times(Traveller())
    with pytest.raises(StartOccupied, match="no free cell is near x=-9"):
        planner.plan(times, ("L0", -9.0, 0.0), ("L1", 1.0, 1.0))
    with pytest.raises(InvalidBuilding, match="no floor 'L9'"):
        planner.plan(times, ("L9", 1.0, 1.0), ("L1", 1.0, 1.0))


def test_a_floor_without_a_costmap_is_refused() -> None:
    with pytest.raises(InvalidBuilding, match="no costmap of floor 'L0'"):
        BuildingPlanner(RandomBuilding.of(1).layout, {})
