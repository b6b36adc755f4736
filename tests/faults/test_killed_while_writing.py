"""kill -9 of the server and of the machine process while paths are asked for: what could be looked up is there."""

import asyncio
import os
import signal
from pathlib import Path

import pytest

from ppaas.errors import PPaaSError
from ppaas.maps.grid import GridMap
from robots.rest import RestClient
from tests.faults.test_kill import lives
from tests.support.cloud import publish_map, running_cloud, until
from tests.support.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

ASKING = 4


@pytest.mark.parametrize("victim", ["server", "machine"])
async def test_paths_that_were_looked_up_outlive_kill_9(victim: str, tmp_path: Path, office_map: GridMap) -> None:
    seen: dict[str, object] = {}
    with running_cloud(tmp_path) as cloud:
        rest = await cloud.admin()
        await publish_map(rest, "office", office_map)
        below = cloud.children()
        asking = [asyncio.create_task(ask_on(rest, office_map, number, seen)) for number in range(ASKING)]
        await until(lambda: len(seen) >= 6, timeout=60.0)
        process = cloud.agent() if victim == "machine" else None
        os.kill(cloud.pid if process is None else process.pid, signal.SIGKILL)
        if process is None:
            cloud.status = -signal.SIGKILL
            await until(lambda: not any(lives(one) for one in below), timeout=20.0)
        else:
            known = len(seen)
            await until(lambda: len(seen) > known + ASKING, timeout=60.0)  # served again, by another
        for task in asking:
            task.cancel()
        await asyncio.gather(*asking, return_exceptions=True)
        if victim == "machine":
            await all_there(rest, seen)
    if victim == "server":
        (tmp_path / "ready.json").unlink()
        with running_cloud(tmp_path) as again:
            await all_there(await again.admin(), seen)


async def ask_on(rest: RestClient, grid: GridMap, number: int, seen: dict[str, object]) -> None:
    """Ask for one path after another, and look each up: then it was acknowledged that it is kept."""
    seed = 1000 * (number + 1)
    while True:
        seed += 2
        start = free_pose(grid, seed=seed)
        try:
            plan = await rest.plan("office", start, reachable_pose(grid, start, seed=seed + 1, at_least=2.0))
            found = await rest.get(f"/v1/plans/{plan['plan_id']}")
        except PPaaSError:
            await asyncio.sleep(0.05)
            continue
        seen[plan["plan_id"]] = found["poses"]


async def all_there(rest: RestClient, seen: dict[str, object]) -> None:
    listed = [plan["plan_id"] for plan in await rest.items("/v1/maps/office/plans")]
    assert set(seen) <= set(listed)
    assert len(listed) == len(set(listed))
    for plan_id in listed:
        poses = (await rest.get(f"/v1/plans/{plan_id}"))["poses"]
        assert poses == seen.get(plan_id, poses)
