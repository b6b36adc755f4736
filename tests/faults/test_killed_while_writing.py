"""SIGKILL of the server or the machine process during writes: acknowledged paths, robots and maps are complete."""

import asyncio
import hashlib
import os
import signal
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from ppaas.errors import PPaaSError
from ppaas.maps.grid import GridMap
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile
from tests.faults.test_kill import lives
from tests.support.cloud.cloud import publish_map, running_cloud
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

ASKING = 4

YAML = b"image: yard.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"
SIDE = 1000


@dataclass
class Written:
    """Acknowledged writes: paths as read back, and counts in the order of writing."""

    paths: dict[str, object] = field(default_factory=dict)
    robots: list[int] = field(default_factory=list)
    maps: list[tuple[int, str]] = field(default_factory=list)

    def is_enough(self) -> bool:
        return len(self.paths) >= 6 and len(self.robots) >= 3 and len(self.maps) >= 3


@pytest.mark.parametrize("victim", ["server", "machine"])
async def test_acknowledged_writes_survive_kill_9(victim: str, tmp_path: Path, office_map: GridMap) -> None:
    seen = Written()
    with running_cloud(tmp_path, "--adopt-within", "0") as cloud:
        rest = await cloud.admin()
        await publish_map(rest, "office", office_map)
        below = cloud.children()
        writing = [ask_on(rest, office_map, number, seen.paths) for number in range(ASKING)]
        writing += [put_robots(rest, seen.robots), publish_on(rest, seen.maps)]
        asking = [asyncio.create_task(one) for one in writing]
        await until(seen.is_enough, timeout=60.0)
        process = cloud.agent() if victim == "machine" else None
        os.kill(cloud.pid if process is None else process.pid, signal.SIGKILL)
        if process is None:
            cloud.status = -signal.SIGKILL
            await until(lambda: not any(lives(one) for one in below), timeout=20.0)
        else:
            known = len(seen.paths)
            await until(lambda: len(seen.paths) > known + ASKING, timeout=60.0)  # another machine process serves again
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
    """Request one path after another and read each back: a path that can be read is acknowledged."""
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


async def put_robots(rest: RestClient, counts: list[int]) -> None:
    """Change a robot repeatedly."""
    count = 0
    while True:
        count += 1
        with suppress(PPaaSError):
            await rest.put_robot("counter", RobotFile(map="office", properties={"count": count}))
            counts.append(count)
        await asyncio.sleep(0.05)


def yard(count: int) -> bytes:
    return b"P5\n%d %d\n255\n" % (SIDE, SIDE) + bytes([count % 256]) * SIDE * SIDE


async def publish_on(rest: RestClient, published: list[tuple[int, str]]) -> None:
    """Publish one version of a map after the other."""
    count = 0
    while True:
        count += 1
        with suppress(PPaaSError):
            answer = await rest.upload_map("yard", YAML, yard(count), message=str(count))
            published.append((count, answer["version"]))
        await asyncio.sleep(0.1)


async def all_there(rest: RestClient, seen: Written) -> None:
    await paths_there(rest, seen.paths)
    robot = await rest.get("/v1/robots/counter")
    assert robot["properties"]["count"] >= seen.robots[-1], "the last acknowledged write, or a later one"
    versions = {one["message"]: one["version"] for one in await rest.items("/v1/maps/yard/versions")}
    assert {str(count): version for count, version in seen.maps}.items() <= versions.items()
    for count, version in ((int(message), version) for message, version in versions.items()):
        image = await rest.fetch(f"/v1/maps/yard/versions/{version}/image")
        assert hashlib.sha256(image).digest() == hashlib.sha256(yard(count)).digest()


async def paths_there(rest: RestClient, seen: dict[str, object]) -> None:
    listed = [plan["plan_id"] for plan in await rest.items("/v1/maps/office/plans")]
    assert set(seen) <= set(listed)
    assert len(listed) == len(set(listed))
    for plan_id in listed:
        poses = (await rest.get(f"/v1/plans/{plan_id}"))["poses"]
        assert poses == seen.get(plan_id, poses)
