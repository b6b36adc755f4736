"""A cloud over a real Cassandra that is killed and restarted: planning and driving continue, and no plan is lost."""

import asyncio
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.generate import office
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from robots.client.rest import RestClient
from tests.faults.test_kill import lives
from tests.servers.cassandra_server import CassandraServer
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import driving
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.servers

BACK = 60.0


@pytest.fixture(scope="module")
def office_map() -> GridMap:
    return office(seed=1, width=12.0, height=10.0)


@pytest.fixture(autouse=True)
def restarted(cassandra_server: CassandraServer) -> Iterator[None]:
    """Start Cassandra again after a test that failed while it was down."""
    yield
    if not cassandra_server.runs:
        cassandra_server.start()
    cassandra_server.empty("cloud")


def ends(grid: GridMap, count: int) -> list[tuple[Pose2D, Pose2D]]:
    """Return distinct starts and goals, because a repeated request may reuse a plan."""
    starts = [free_pose(grid, seed=60 + number) for number in range(count)]
    return [(start, reachable_pose(grid, start, seed=90 + n, at_least=4.0)) for n, start in enumerate(starts)]


async def ask(rest: RestClient, grid: GridMap, count: int) -> list[str]:
    """Request paths, and return the ids of the stored plans."""
    return [(await rest.plan("office", start, goal))["plan_id"] for start, goal in ends(grid, count)]


async def health_when(rest: RestClient, status: str) -> Any:
    """Return the cloud's health report once it has this state."""
    async with patience(BACK):
        while (health := await rest.get("/v1/health"))["status"] != status:
            await asyncio.sleep(0.2)
    return health


async def test_planning_and_driving_continue_while_cassandra_is_down(
    tmp_path: Path, office_map: GridMap, cassandra_server: CassandraServer
) -> None:
    with running_cloud(tmp_path, "--store", cassandra_server.url("cloud")) as cloud:
        rest = await cloud.admin()
        await publish_map(rest, "office", office_map)
        start, goal = ends(office_map, 1)[0]
        token = await register_robot(rest, "f", "office", start)
        before = await ask(rest, office_map, 2)
        assert (await rest.get("/v1/health"))["status"] == "ok"
        async with driving(cloud.url, token, "f", office_map, start) as drive:
            await asyncio.to_thread(cassandra_server.kill)
            await drive.send(goal, goal_id="away")
            meanwhile = await ask(rest, office_map, 5)
            health = await health_when(rest, "degraded")
            assert health["store"]["state"] == "away"
            assert "start Cassandra" in health["store"]["reason"]
            assert (await rest.get("/v1/health"))["plans_waiting"] >= 1
            assert (await rest.get(f"/v1/plans/{meanwhile[0]}"))["plan_id"] == meanwhile[0]
            result = await drive.result()
            assert result.status.status == Status.SUCCEEDED, result.status.text
        await asyncio.to_thread(cassandra_server.start)
        await health_when(rest, "ok")
        kept = [plan["plan_id"] for plan in await rest.items("/v1/maps/office/plans")]
        assert set(before + meanwhile) <= set(kept)
        assert len(kept) == len(set(kept))
        assert len(kept) > len(set(before + meanwhile)), "the robot's own plan waited with the machine process"


@pytest.mark.parametrize("victim", ["machine", "cloud"])
async def test_queued_plans_survive_kill_9(
    victim: str, tmp_path: Path, office_map: GridMap, cassandra_server: CassandraServer
) -> None:
    with running_cloud(tmp_path, "--store", cassandra_server.url("cloud"), "--adopt-within", "0") as cloud:
        rest = await cloud.admin()
        await publish_map(rest, "office", office_map)
        await ask(rest, office_map, 1)
        await asyncio.to_thread(cassandra_server.kill)
        waiting = await ask(rest, office_map, 4)
        for plan_id in waiting:  # a plan that was read back was acknowledged
            await rest.get(f"/v1/plans/{plan_id}")
        await kill(cloud, victim)
        await asyncio.to_thread(cassandra_server.start)
        if victim == "machine":
            waiting += await served_again(rest, office_map)
            await arrived(rest, waiting)
    if victim == "cloud":
        (tmp_path / "ready.json").unlink()
        with running_cloud(tmp_path, "--store", cassandra_server.url("cloud")) as again:
            await arrived(await again.admin(), waiting)


async def kill(cloud: RunningCloud, victim: str) -> None:
    below = cloud.children()
    if victim == "machine":
        agent = cloud.agent()
        os.kill(agent.pid, signal.SIGKILL)
        await until(lambda: not lives(agent))
        return
    os.kill(cloud.pid, signal.SIGKILL)
    cloud.status = -signal.SIGKILL
    await until(lambda: not any(lives(process) for process in below))


async def served_again(rest: RestClient, grid: GridMap) -> list[str]:
    """Retry until a machine has registered again, and the master may start containers, since its lease is renewed."""
    async with patience(BACK):
        while True:
            try:
                return await ask(rest, grid, 1)
            except Exception:  # noqa: BLE001 - any error while the machine registers
                await asyncio.sleep(0.2)


async def arrived(rest: RestClient, waiting: list[str]) -> None:
    await health_when(rest, "ok")
    kept = [plan["plan_id"] for plan in await rest.items("/v1/maps/office/plans")]
    assert set(waiting) <= set(kept)
    assert len(kept) == len(set(kept))
