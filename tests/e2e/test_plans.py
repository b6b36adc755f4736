"""Paths without a robot are planned in a container and never in the web process; a request may wait in the queue."""

import asyncio

import pytest

from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidInput, NotFound, PPaaSError, QuotaExceeded
from ppaas.maps.grid import OCCUPIED, GridMap
from robots.client.rest import RestClient
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.waiting import patience
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey


async def test_a_path_is_planned_in_another_process_than_the_web_server(
    cloud: RunningCloud, office_map: GridMap
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=20)
    goal = reachable_pose(office_map, start, seed=21, at_least=4.0)
    plan = await rest.plan("office", start, goal)
    assert plan["pid"] != cloud.pid
    assert plan["pid"] in {child.pid for child in cloud.children()}
    assert plan["length"] >= start.distance_to(goal)
    assert plan["container"] in {c["id"] for c in await rest.items("/v1/containers") if c["kind"] == "planning"}
    again = await rest.plan("office", start, goal)
    assert again["pid"] == plan["pid"], "the same container plans again"


async def test_parameters_of_a_request_change_the_path_and_its_id(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=20)
    goal = reachable_pose(office_map, start, seed=21, at_least=4.0)
    usual = await rest.plan("office", start, goal)
    wide = await rest.plan("office", start, goal, parameters={"inflation_radius": 2.0, "cost_scaling_factor": 1.0})
    assert wide["plan_id"] != usual["plan_id"]
    assert wide["cost"] > usual["cost"]
    assert wide["conditions"]["global_costmap"] == {"inflation_radius": 2.0, "cost_scaling_factor": 1.0}
    with pytest.raises(InvalidInput, match="no parameter 'speed'; known: allow_unknown"):
        await rest.plan("office", start, goal, parameters={"speed": 1})


async def test_planning_errors_are_raised_by_their_type(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=22)
    wall = next(iter(office_map.info.to_world(list(zip(*(office_map.data == OCCUPIED).nonzero(), strict=True)))))
    with pytest.raises(GoalOccupied):
        await rest.plan("office", start, (*map(float, wall), 0.0))
    with pytest.raises(GoalOutsideMap):
        await rest.plan("office", start, (1e6, 0.0, 0.0))
    with pytest.raises(NotFound, match="atlantis"):
        await rest.plan("atlantis", start, start)
    with pytest.raises(PPaaSError, match="dijkstra"):
        await rest.plan("office", start, start, planner="oracle")


PASSWORD = "correct horse"


async def test_a_queued_path_is_planned_when_its_turn_comes(cloud: RunningCloud, office_map: GridMap) -> None:
    admin = await cloud.admin()
    await admin.post("/v1/users", {"id": "quinn", "password": PASSWORD})
    await admin.patch("/v1/users/quinn", {"limits": {"containers": 1}})
    login = await RestClient(cloud.url).login("quinn", PASSWORD)
    rest = RestClient(cloud.url, login.token)
    for name in ("q1", "q2"):
        await publish_map(rest, name, office_map)
    start = free_pose(office_map, seed=40)
    goal = reachable_pose(office_map, start, seed=41, at_least=4.0)
    await rest.plan("q1", start, goal)
    body = {"start": [start.x, start.y], "goal": [goal.x, goal.y]}
    with pytest.raises(QuotaExceeded, match="1 containers and has 1"):
        await rest.post("/v1/maps/q2/plans", body)
    waits = await rest.post("/v1/maps/q2/plans", body | {"queue": True})
    assert waits["position"] == 1
    await admin.patch("/v1/users/quinn", {"limits": {"containers": 2}})
    async with patience(20):
        while "poses" not in (answer := await rest.post("/v1/maps/q2/plans", body | {"queue": True})):
            assert answer["position"] == 1
            await asyncio.sleep(0.02)
