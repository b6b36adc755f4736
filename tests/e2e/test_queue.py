"""Path requests that wait in the queue in place of a refusal."""

import asyncio

import pytest

from ppaas.errors import QuotaExceeded
from ppaas.maps.grid import GridMap
from robots.client.rest import RestClient
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.waiting import patience
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey
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
