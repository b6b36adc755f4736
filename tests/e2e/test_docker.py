"""A cloud with containers of the Docker Engine: robots drive, and plug-ins find no data of other users."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ppaas.errors import NotPermitted, NoValidPath
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from tests.e2e.test_masks import careful_robot, passed
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import driving
from tests.support.engine.docker_engine import image_for_tests, run
from tests.support.hostile_plugin import hostile
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = [pytest.mark.journey, pytest.mark.docker, pytest.mark.timeout(600)]

PASSWORD = "a password of some length"


@pytest.fixture(scope="module")
def contained(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningCloud]:
    """Return a cloud whose image contains a hostile plug-in that its administrator allowed by mistake."""
    arguments = ["--runtime", "docker", "--image", image_for_tests(), "--allow", "ppaas.planners:hostile"]
    with running_cloud(tmp_path_factory.mktemp("contained"), *arguments) as running:
        yield running


async def user(cloud: RunningCloud, name: str) -> RestClient:
    """Return the client of a user, who is created if missing."""
    admin = await cloud.admin()
    await admin.post("/v1/users", {"id": name, "password": PASSWORD})
    client = RestClient(cloud.url)
    await client.login(name, PASSWORD)
    return client


async def test_a_robot_continues_its_goal_after_its_container_is_killed(
    contained: RunningCloud, office_map: GridMap
) -> None:
    rest = await contained.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=1)
    goals = [reachable_pose(office_map, start, seed=n, at_least=4.0) for n in (2, 3)]
    token = await register_robot(rest, "tb1", "office", start)
    async with driving(contained.url, token, "tb1", office_map, start) as drive:
        assert await drive.go(goals[0]) <= 0.25
        await drive.send(goals[1], "second")
        count = len(drive.commands)
        await until(lambda: len(drive.commands) > count + 5)
        [before] = [view["pid"] for view in await rest.items("/v1/containers") if view["robot"] == "tb1"]
        run("kill", "-9", str(before))
        assert (await drive.result()).status.goal_id.id == "second"
        assert drive.scorer.collisions(0) == 0
        [after] = [view["pid"] for view in await rest.items("/v1/containers") if view["robot"] == "tb1"]
    assert after != before


async def test_a_container_without_a_network_respects_keepout_masks(
    contained: RunningCloud,
) -> None:
    token = await careful_robot(await contained.admin(), "boxed")
    async with RobotClient(contained.ws_url, robot="boxed", token=token) as client:
        assert await passed(client) == {True}


async def findings(rest: RestClient, map_id: str, start: Pose2D, goal: Pose2D) -> dict[str, Any]:
    """Return what the hostile planner found."""
    with pytest.raises(NoValidPath) as raised:
        await rest.plan(map_id, (start.x, start.y), (goal.x, goal.y), planner="hostile")
    text = str(raised.value)
    found: dict[str, Any] = json.loads(text[text.index("{") : text.rindex("}") + 1])
    return found


async def test_a_hostile_plugin_reads_no_files_or_topics_of_other_users(
    contained: RunningCloud, office_map: GridMap
) -> None:
    ann, bob = await user(contained, "ann"), await user(contained, "bob")
    start = free_pose(office_map, seed=1)
    goal = reachable_pose(office_map, start, seed=2, at_least=4.0)
    await publish_map(ann, "anns", office_map)
    await publish_map(bob, hostile.OTHERS, office_map)
    token = await register_robot(bob, "bobs", hostile.OTHERS, start)
    async with driving(contained.url, token, "bobs", office_map, start):
        outside = hostile._of_others()
        assert any(path.startswith("/dev/shm/") for path in outside), "data of others exists"
        found = await findings(ann, "anns", start, goal)
    assert found["of_others"] == []
    given = ["gate.sock", "link.sock", "relay.sock", "start.sock"]
    assert found["sockets"] == [f"/run/ppaas/{name}" for name in given]
    assert len(found["processes"]) <= 2, "its own process and the init process"
    assert found["interfaces"] == ["lo"]
    assert found["reached"] == found["wrote"] == []
    assert (found["capabilities"], found["no_new_privileges"], found["became_root"]) == (0, "1", False)
    assert found["user"] > 0


async def test_resizing_a_container_changes_its_limits_and_kernel_threads(
    contained: RunningCloud, office_map: GridMap
) -> None:
    dora = await user(contained, "dora")
    start = free_pose(office_map, seed=1)
    goal = reachable_pose(office_map, start, seed=2, at_least=4.0)
    await publish_map(dora, "doras", office_map)
    plan = await dora.plan("doras", (start.x, start.y), (goal.x, goal.y))
    of_map = 64 * office_map.data.size
    for cores, threads, memory in ((2.0, 2, 1536 << 20), (0.5, 1, 768 << 20)):
        resized = await dora.patch(f"/v1/containers/{plan['container']}", {"cores": cores})
        assert resized["cores"] == cores
        await until(lambda pid=resized["pid"], size=(cores, memory + of_map): limits_of(pid) == size)
        found = await findings(dora, "doras", start, goal)
        assert found["threads"] == threads
        again = await dora.plan("doras", (goal.x, goal.y), (start.x, start.y))
        assert (again["container"], again["pid"]) == (plan["container"], plan["pid"]), "the process is the same"


def limits_of(pid: int) -> tuple[float, int]:
    """Return the limits of the container of a process: CPUs and memory [bytes]."""
    cgroup = Path(f"/proc/{pid}/cgroup").read_text()
    [container] = [name for name in run("docker", "ps", "--quiet", "--no-trunc").split() if name in cgroup]
    host = json.loads(run("docker", "inspect", container))[0]["HostConfig"]
    return host["CpuQuota"] / host["CpuPeriod"], host["Memory"]


async def test_a_plugin_that_is_not_allowed_does_not_run(contained: RunningCloud, office_map: GridMap) -> None:
    carl = await user(contained, "carl")
    await publish_map(carl, "carls", office_map)
    start = free_pose(office_map, seed=1)
    goal = reachable_pose(office_map, start, seed=2, at_least=4.0)
    with pytest.raises(NotPermitted, match=r"not allowed; allow it with: ppaas up --allow ppaas\.planners:curious"):
        await carl.plan("carls", (start.x, start.y), (goal.x, goal.y), planner="curious")


def test_the_hostile_plugin_finds_existing_files_and_processes(tmp_path: Path) -> None:
    (tmp_path / hostile.OTHERS).mkdir()
    found = hostile.findings()
    assert str(tmp_path / hostile.OTHERS) in found["of_others"]
    assert found["processes"]
