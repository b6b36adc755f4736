"""Ways of an area: on each floor by its container, over floors by the building, and straight without either."""

import json
from collections.abc import Sequence
from typing import Any
from unittest.mock import Mock

import pytest
from msgspec import Raw

from engine.control.planning.building_requests import BuildingSpot
from engine.control.planning.requests import CostAnswer, CostRequest
from engine.control.tasks.areas import TaskArea
from engine.control.tasks.measuring import AreaWays
from engine.control.tasks.task_maps import TaskMap, sites_on_floors
from engine.specs.containers import MapVersion
from ppaas.energy.sites import Sites
from ppaas.errors import Unavailable
from ppaas.planners.weights import NEUTRAL
from ppaas.tasks.dispatcher import Dispatcher
from ppaas.tasks.floors import on_floor
from ppaas.tasks.orders import RobotNow
from ppaas.tasks.reach import SPEED, straight
from ppaas.tasks.records import Task

A, B = (0.0, 0.0, 0.0), (10.0, 0.0, 0.0)
AREA = TaskArea("ann", (("L1", "m1"), ("L2", "m2")))
MAPS = {floor: TaskMap(MapVersion(name, "v"), resolution=NEUTRAL) for floor, name in AREA.maps}


def scene(*floors: str) -> Dispatcher:
    """Return a dispatcher with a robot on each floor, and a task on each, which may name floors."""
    tasks = [Task(id=name, kind="go_to", places=(B,), home=name, floors=floors) for name in ("L1", "L2")]
    dispatcher = Dispatcher(tasks, 0.0)
    dispatcher.see({name: RobotNow(on_floor(A, name)) for name in ("L1", "L2")}, 0.0)
    return dispatcher


class Cloud:
    """Planning containers and the leader of journeys."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, CostRequest]] = []
        self.error: Exception | None = None

    async def costs(self, user: str, version: MapVersion, request: CostRequest) -> CostAnswer:
        self.asked.append((version.id, request))
        if self.error is not None:
            raise self.error
        length = {"m1": 15.0, "m2": 25.0}[version.id]
        return CostAnswer(Raw(json.dumps([[length]]).encode()), 0.1, "c", 9, version.id, version.version)

    async def times(
        self, user: str, map_id: str, starts: Sequence[BuildingSpot], goals: Sequence[BuildingSpot]
    ) -> list[list[float | None]]:
        assert (user, map_id, [spot.floor for spot in starts]) == ("ann", "m1", ["L1", "L2"])
        return [[60.0 if start.floor == goal.floor else None for goal in goals] for start in starts]

    @property
    def ways(self) -> AreaWays:
        journeys: Any = self
        return AreaWays(self.costs, journeys, AREA, MAPS)


async def test_tasks_without_floors_are_measured_on_each_floor() -> None:
    cloud = Cloud()
    distance = await cloud.ways.measure(scene(), 0.0)
    assert [distance(on_floor(A, floor), on_floor(B, floor)) for floor in ("L1", "L2")] == [15.0, 25.0]
    assert [(name, request.starts, request.goals) for name, request in cloud.asked] == [
        ("m1", (A,), (B,)), ("m2", (A,), (B,)),
    ]  # fmt: skip


async def test_tasks_over_floors_are_measured_by_the_times_in_the_building() -> None:
    cloud = Cloud()
    distance = await cloud.ways.measure(scene("L2"), 0.0)
    assert distance(on_floor(A, "L2"), on_floor(B, "L2")) == 60.0 * SPEED
    assert distance(on_floor(A, "L1"), on_floor(B, "L2")) == float("inf")
    assert cloud.asked == []


@pytest.mark.parametrize("error", [Unavailable("no machine has room"), TimeoutError()])
async def test_straight_lines_count_while_nobody_answers(error: Exception) -> None:
    cloud = Cloud()
    cloud.error = error
    assert await cloud.ways.measure(scene(), 0.0) is straight
    cloud.times = Mock(side_effect=error)  # type: ignore[method-assign]
    assert await cloud.ways.measure(scene("L2"), 0.0) is straight


def test_chargers_of_all_floors_are_known_with_their_floors_and_those_that_are_linked() -> None:
    links = {"L1": {"north"}, "L2": {"north", "ramp"}, "L3": {"ramp"}, "L4": {"south"}}
    maps = {
        floor: TaskMap(
            MapVersion(floor, "v"),
            Sites(chargers={"a": A}, parking={"p": B} if floor == "L1" else {}),
            links=frozenset(names),
        )
        for floor, names in links.items()
    }
    sites = sites_on_floors(maps)
    assert sites.chargers == {f"{floor}/a": on_floor(A, floor) for floor in links}
    assert sites.parking == {"L1/p": on_floor(B, "L1")}
    assert sites.leads("L1", "L3") and sites.leads("L3", "L1") and sites.leads("L4", "L4")
    assert not sites.leads("L1", "L4") and not sites.leads("L4", "L2")
    alone = Sites(chargers={"a": A})
    assert sites_on_floors({"": TaskMap(MapVersion("m", "v"), alone)}) is alone
