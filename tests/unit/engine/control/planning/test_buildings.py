"""Plans over floors from lengths that containers compute: as exact as in one process, and asked for when needed."""

import math
from typing import Any

import msgspec
import numpy as np
import pytest
from msgspec import Raw

from engine.control.planning.building_requests import KEPT_SECONDS, BuildingScene, BuildingSpot, KeptLengths
from engine.control.planning.buildings import BuildingPlanning
from engine.control.planning.planning import Planning
from engine.control.planning.requests import CostAnswer, CostRequest
from engine.specs.containers import MapVersion
from ppaas.buildings.building import Building, Floor
from ppaas.buildings.layout import layout_of
from ppaas.buildings.planning.planner import BuildingPlanner
from ppaas.buildings.planning.sessions import Session
from ppaas.buildings.planning.times import Traveller
from ppaas.errors import InvalidBuilding, NoValidPath
from ppaas.geometry import Poses, poses_along
from ppaas.plans.path_service import PathAnswer, PathRequest
from ppaas.zones.zone import ZoneSet
from tests.unit.ppaas.buildings.planning.random_buildings import (
    RandomBuilding,
    door,
    lift,
    shut,
    two_floors,
)

TRAVELLER = Traveller(speed=0.8, stairs=True, labels={"legs": "4"})


class IndexedPlanning(Planning):
    """Planning whose lengths are those of a planner in this process; its paths are straight lines."""

    def __init__(self, planner: BuildingPlanner) -> None:
        super().__init__(use=None)  # type: ignore[arg-type]  # no container is used
        self.floors = {f"m{number}": floor for number, floor in enumerate(planner.floors)}
        self.asked: list[str] = []
        self.paths_asked: list[PathRequest] = []

    async def compute_costs(self, user: str, version: MapVersion, request: CostRequest) -> CostAnswer:
        assert request.parameters == {"shut_doors": True, "lengths": True}
        self.asked.append(version.id)
        paths = self.floors[version.id].paths
        starts, goals = ([paths.cell(*place[:2]) for place in places] for places in (request.starts, request.goals))
        rows = [
            [each if math.isfinite(each) else None for each in row] for row in paths.between(starts, goals).tolist()
        ]
        return CostAnswer(Raw(msgspec.json.encode(rows)), 0.0, "c1", 1, version.id, version.version)

    async def compute_path(self, user: str, version: MapVersion, request: PathRequest) -> tuple[PathAnswer, Poses]:
        self.paths_asked.append(request)
        points = np.array([request.start[:2], request.goal[:2]])
        answer = PathAnswer(
            b"", 0.0, 1.0, 2, 0.0, request.planner, "p", "computed", None, Raw(b"{}"), "c1", 1, version.id, "v"
        )
        return answer, poses_along(points, 0.0)


def scene_of(building: RandomBuilding, **changes: Any) -> BuildingScene:
    maps = {floor.name: MapVersion(floor.map, "v1") for floor in building.layout.building.floors}
    return BuildingScene(building.layout, maps, **({"traveller": TRAVELLER} | changes))


def spot(place: tuple[str, float, float]) -> BuildingSpot:
    return BuildingSpot(*place)


@pytest.mark.parametrize("seed", range(12))
async def test_plans_and_costs_are_those_of_a_planner_in_one_process(seed: int) -> None:
    building, rng = RandomBuilding.of(seed), np.random.default_rng(seed)
    planner = building.planner()
    planning = BuildingPlanning(IndexedPlanning(planner), KeptLengths())
    times, free = planner.times(TRAVELLER), shut(planner)
    places = [building.spot(rng) for _ in range(6)]
    places = [given for own, given in places if free[own[0]][own[1:]]]
    scene = scene_of(building)
    for start in places:
        for goal in places:
            found = planner.plan(times, start, goal)
            if found is None:
                with pytest.raises(NoValidPath, match="no route leads from"):
                    await planning.plan("ann", scene, spot(start), spot(goal))
                continue
            [route] = await planning.plan("ann", scene, spot(start), spot(goal))
            assert route.seconds == pytest.approx(found.seconds, abs=1e-4)
            assert sum(leg.seconds for leg in route.legs) == pytest.approx(route.seconds, abs=1e-4)
    costs = await planning.costs("ann", scene, [spot(each) for each in places], [spot(each) for each in places])
    assert costs == pytest.approx(planner.costs(times, places, places), abs=1e-4)


def tower() -> tuple[RandomBuilding, BuildingPlanner]:
    """Return five floors without walls, with two lifts that stop on all of them."""
    zones = ZoneSet([*lift("north", 1.0, 1.0), *lift("south", 4.0, 2.5), door("hall", 2.5, 4.0)])
    floors = tuple(Floor(name=f"L{n}", map=f"m{n}", elevation=4.0 * n) for n in range(5))
    layout = layout_of(Building(floors=floors), {floor.name: zones for floor in floors})
    building = RandomBuilding(layout, [np.ones((24, 24), np.bool_) for _ in floors])
    return building, building.planner()


async def test_floors_that_no_route_crosses_are_not_asked_and_lengths_are_kept() -> None:
    building, planner = tower()
    indexed, now = IndexedPlanning(planner), 0.0
    planning = BuildingPlanning(indexed, KeptLengths(lambda: now))
    start, goal = BuildingSpot("L0", 0.5, 0.5), BuildingSpot("L4", 5.5, 5.5)
    await planning.plan("ann", scene_of(building), start, goal)
    assert set(indexed.asked) == {"m0", "m4"}
    first = len(indexed.asked)
    await planning.plan("ann", scene_of(building), start, goal)
    assert len(indexed.asked) - first == 2, "the ends alone"
    now += KEPT_SECONDS + 1.0
    await planning.plan("ann", scene_of(building), start, goal)
    assert len(indexed.asked) - first == 2 + first


async def test_the_first_route_has_the_paths_of_its_drives_and_others_none() -> None:
    building, planner = tower()
    indexed = IndexedPlanning(planner)
    planning = BuildingPlanning(indexed, KeptLengths())
    start, goal = BuildingSpot("L0", 0.5, 0.5, 1.0), BuildingSpot("L4", 5.5, 5.5, 2.0)
    best, other = await planning.plan("ann", scene_of(building, reuse=False), start, goal, count=2)
    assert {best.names, other.names} == {("north",), ("south",)}
    assert [path is not None for path in best.paths] == [leg.kind == "drive" for leg in best.legs]
    assert other.paths == []
    first, last = indexed.paths_asked
    assert (first.start, last.goal) == ((0.5, 0.5, 1.0), (5.5, 5.5, 2.0))
    assert (first.planner, first.reuse, first.parameters) == ("hub_labels", False, {"shut_doors": True})


async def test_a_robot_in_a_car_needs_no_place_on_a_floor() -> None:
    building, planner = tower()
    planning = BuildingPlanning(IndexedPlanning(planner), KeptLengths())
    nowhere, goal = BuildingSpot("L0", -99.0, 0.0), BuildingSpot("L4", 5.5, 5.5)
    session = Session("north", "L2", inside=True, to="L4")
    [route] = await planning.plan("ann", scene_of(building), nowhere, goal, session=session)
    assert [(leg.kind, leg.floor, leg.to_floor) for leg in route.legs] == [("lift", "L2", "L4"), ("drive", "L4", "L4")]


async def test_a_floor_without_a_readable_map_is_not_crossed_and_not_entered() -> None:
    building = two_floors()
    planning = BuildingPlanning(IndexedPlanning(building.planner()), KeptLengths())
    scene = BuildingScene(building.layout, {"L0": MapVersion("m0", "v1")})
    there = BuildingSpot("L1", 1.0, 1.0)
    with pytest.raises(NoValidPath, match="floor 'L1' has no map that you may read"):
        await planning.plan("ann", scene, BuildingSpot("L0", 1.0, 1.0), there)
    with pytest.raises(InvalidBuilding, match="no floor 'L7'"):
        await planning.plan("ann", scene, BuildingSpot("L7", 1.0, 1.0), BuildingSpot("L0", 1.0, 1.0))


async def test_a_lift_out_of_order_is_not_taken_and_named_if_there_is_no_other() -> None:
    building, planner = tower()
    planning = BuildingPlanning(IndexedPlanning(planner), KeptLengths())
    start, goal = BuildingSpot("L0", 0.5, 0.5), BuildingSpot("L4", 0.5, 0.5)
    usual = building.layout.building.lift("north").wait
    taken = []
    for waits in ({}, {("north", "L0"): usual + 60.0}, {("north", "L0"): math.inf}, {("south", "L0"): math.inf}):
        [route] = await planning.plan("ann", scene_of(building, waits=waits), start, goal)
        taken.append(route.names)
    assert taken == [("north",), ("south",), ("south",), ("north",)]
    broken = {("north", "L0"): math.inf, ("south", "L0"): math.inf}
    with pytest.raises(NoValidPath, match="lifts that do not serve robots now: north, south"):
        await planning.plan("ann", scene_of(building, waits=broken), start, goal)
