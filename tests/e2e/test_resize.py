"""Containers are resized while they run."""

import os
from pathlib import Path

import pytest

from ppaas.errors import PPaaSError
from ppaas.maps.grid import GridMap
from robots.client.rest import RestClient
from tests.support.cloud.cloud import ADMIN_PASSWORD, RunningCloud, publish_map
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey


async def used_cores(rest: RestClient) -> float:
    return float((await rest.get("/v1/users/me"))["used"]["cores"])


async def test_a_resized_container_keeps_planning_on_other_cpus(cloud: RunningCloud, office_map: GridMap) -> None:
    admin, rest = await cloud.admin(), RestClient(cloud.url)
    await admin.post("/v1/users", {"id": "rena", "password": ADMIN_PASSWORD})  # containers of other tests are not hers
    await rest.login("rena", ADMIN_PASSWORD)
    await publish_map(rest, "resized", office_map)
    start = free_pose(office_map, seed=30)
    goal = reachable_pose(office_map, start, seed=31, at_least=4.0)
    plan = await rest.plan("resized", start, goal)
    path, pid = f"/v1/containers/{plan['container']}", plan["pid"]
    assert await used_cores(rest) == 1.0
    wide = min(2, os.cpu_count() or 1)
    for size in (float(wide), 0.5):
        resized = await rest.patch(path, {"cores": size})
        assert (resized["cores"], resized["pid"]) == (size, pid)
        assert await used_cores(rest) == size
        await until(lambda size=size: {len(cpus) for cpus in cpus_of(pid)} == {max(1, int(size))})  # type: ignore[misc]
        again = await rest.plan("resized", start, goal)
        assert (again["pid"], again["container"]) == (pid, plan["container"])
    with pytest.raises(PPaaSError, match="cores"):
        await rest.patch(path, {"cores": 1e4})


def cpus_of(pid: int) -> list[set[int]]:
    return [os.sched_getaffinity(int(task.name)) for task in Path(f"/proc/{pid}/task").iterdir()]
