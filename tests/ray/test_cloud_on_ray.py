"""A cloud whose machines are the nodes of a real Ray cluster: they join, are killed and leave while robots drive."""

import asyncio
import contextlib
import itertools
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest
from playwright.async_api import expect

from benchmarks.harness.free_ports import free_ports
from engine.remote.ray import agent
from engine.remote.ray.watcher_process import WATCHER
from ppaas.maps.generate import office
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from robots.client.rest import RestClient
from tests.ray.ray_cluster import RayCluster, RayNode
from tests.support.cloud.browser import DESK, browsing, enter, looking
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import Drive, driving
from tests.support.cloud.up_process import Up
from tests.support.engine.processes import has_ended
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = [pytest.mark.ray, pytest.mark.timeout(600)]

HERE = 120.0
"""Time limit until a node becomes a machine [s]: Ray takes several seconds to start one, and more on a busy host."""


@pytest.fixture(scope="module")
def office_map() -> GridMap:
    return office(seed=1, width=12.0, height=10.0)


@pytest.fixture
def cluster(monkeypatch: pytest.MonkeyPatch) -> Iterator[RayCluster]:
    """Return a running cluster with only its head; child processes get its token."""
    running = RayCluster()
    for name, value in running.credentials.items():
        monkeypatch.setenv(name, value)
    try:
        yield running
    finally:
        running.stop()


def on_ray(cluster: RayCluster, port: int = 0) -> tuple[str, ...]:
    """Return the arguments of a cloud on a cluster, which keeps clones for longer than a node takes to join."""
    at = ("--ray-address", cluster.address, "--listen-machines", f"127.0.0.1:{port}")
    return ("--runtime", "ray", *at, "--linger", "300")


async def machines_when(rest: RestClient, holds: Callable[[list[dict[str, Any]]], object]) -> list[dict[str, Any]]:
    """Return the machines that have joined once a condition holds for them."""
    async with patience(HERE):
        while not holds(machines := [one for one in await rest.items("/v1/machines") if one["state"] != "starting"]):
            await asyncio.sleep(0.05)
    return machines


async def check_endpoints(rest: RestClient, machines: set[str]) -> None:
    """Check that each machine has an endpoint, which answers at the address of its node."""
    async with patience(HERE):
        while not machines <= {endpoint["machine"] for endpoint in await rest.items("/v1/endpoints")}:
            await asyncio.sleep(0.1)
    for endpoint in await rest.items("/v1/endpoints"):
        # An endpoint learns by its next report that machines have joined.
        async with patience(HERE):
            while (health := await RestClient(endpoint["url"]).get("/v1/health"))["status"] == "starting":
                await asyncio.sleep(0.1)
        assert (health["endpoint"], health["status"]) == (endpoint["id"], "ok")


async def containers(rest: RestClient) -> dict[str, dict[str, Any]]:
    """Return the container of each robot."""
    return {container["robot"]: container for container in await rest.items("/v1/containers")}


async def another(rest: RestClient, robot: str, than: dict[str, Any]) -> dict[str, Any]:
    """Return the container of a robot once it is another one and ready."""
    async with patience(HERE):
        while True:
            found = (await containers(rest)).get(robot)
            if found is not None and found["id"] != than["id"] and found["state"] == "ready":
                return found
            await asyncio.sleep(0.01)


def longest_gap(drive: Drive) -> float:
    """Return the longest time without a command [s]."""
    return max(after - before for before, after in itertools.pairwise(time for time, _ in drive.commands))


class Fleet:
    """Driving robots, each on its own map."""

    def __init__(self, cloud: RunningCloud, rest: RestClient, grid: GridMap) -> None:
        self.cloud, self.rest, self.grid = cloud, rest, grid

    async def drive(self, number: int, begun: asyncio.Event, fault: asyncio.Event) -> float:
        """Drive one robot; set ``begun`` when it moves, and drive to the end; return its longest command gap [s]."""
        start = free_pose(self.grid, seed=30 + number)
        goal = reachable_pose(self.grid, start, seed=40 + number, at_least=4.0)
        token = await register_robot(self.rest, f"r{number}", f"office-{number}", start)
        async with driving(self.cloud.url, token, f"r{number}", self.grid, start) as drive:
            await drive.send(goal, goal_id=f"goal-{number}")
            async with patience(HERE):
                while len(drive.commands) <= 5:
                    await asyncio.sleep(0.01)
            begun.set()
            await fault.wait()
            result = await drive.result()
            assert result.status.goal_id.id == f"goal-{number}"
            assert result.status.status == Status.SUCCEEDED, result.status.text
            assert drive.scorer.error(0, goal) <= 0.25
            assert drive.results.empty(), "one result a goal"
            assert drive.robot.connections == 1, "the robot's socket was kept open"
            return longest_gap(drive)


async def test_robots_continue_while_nodes_die_and_join(
    tmp_path: Path, cluster: RayCluster, office_map: GridMap, record_property: Callable[[str, object], None]
) -> None:
    nodes = {f"h{number}": cluster.join(f"--labels=host=h{number}") for number in (1, 2)}
    [port] = free_ports(1)
    with running_cloud(tmp_path, *on_ray(cluster), "--ray-endpoints", "1", "--port", str(port)) as cloud:
        rest = await cloud.admin()
        machines = await machines_when(rest, lambda all_: len(all_) == 2)
        assert {machine["labels"]["host"] for machine in machines} == set(nodes)
        await check_endpoints(rest, {machine["id"] for machine in machines})
        host_of = {machine["id"]: machine["labels"]["host"] for machine in machines}
        await limit(rest, host_of, 1)  # so that each gets one robot, however busy their common host is
        for number in (1, 2):
            await publish_map(rest, f"office-{number}", office_map)
        fleet = Fleet(cloud, rest, office_map)
        begun, fault = [asyncio.Event(), asyncio.Event()], asyncio.Event()
        async with asyncio.TaskGroup() as group:
            drives = [group.create_task(fleet.drive(number + 1, begun[number], fault)) for number in range(2)]
            await asyncio.gather(*(event.wait() for event in begun))
            before = await containers(rest)
            assert {host_of[container["machine"]] for container in before.values()} == set(nodes), "one map a node"
            await check_dashboard(cloud, rest, before, tmp_path / "dashboard.png")
            record_property("ready_s", [container["ready_seconds"] for container in before.values()])
            crashed = await crash(rest, "r1")
            record_property("crash_to_ready_s", crashed)
            record_property("ready_again_s", (await containers(rest))["r1"]["ready_seconds"])
            before = await containers(rest)  # a busy computer may have lost one of them meanwhile
            await limit(rest, host_of, 100)
            lost = nodes.pop(host_of[before["r2"]["machine"]])
            record_property("node_lost_to_ready_s", await lose(rest, lost, before["r2"]))
            assert (await containers(rest))["r2"]["machine"] == before["r1"]["machine"]
            fault.set()
        record_property("longest_gaps_s", [drive.result() for drive in drives])
        await join_and_take_over(rest, cluster, nodes.popitem()[1])
    await wait_until_nothing_is_left(cluster)


async def check_dashboard(
    cloud: RunningCloud, rest: RestClient, carried: dict[str, dict[str, Any]], picture: Path
) -> None:
    """Check that the dashboard shows both machines with their robots, and each robot on its map."""
    assert rest.token is not None
    async with browsing() as browser, looking(await browser.new_context(viewport=DESK)) as page:
        await enter(page, cloud.url, rest.token)
        for robot, container in carried.items():
            machine = page.locator("#machines > li", has_text=container["machine"])
            await expect(machine).to_contain_text("1 container")
            line = page.locator("#containers > li", has_text=f"admin / {robot}")
            await expect(line).to_contain_text(container["machine"])
            await page.locator("#map-choice").select_option(container["map"]["id"])
            await expect(page.get_by_role("button", name=robot)).to_contain_text("online")
        await page.screenshot(path=picture)
        assert await page.locator("#panel-load").evaluate("panel => panel.scrollWidth <= panel.clientWidth")


async def limit(rest: RestClient, machines: Iterable[str], containers: int) -> None:
    """Set the largest number of containers of machines."""
    for machine in machines:
        await rest.patch(f"/v1/machines/{machine}", {"max_containers": containers})


async def crash(rest: RestClient, robot: str) -> float:
    """Kill the container of a robot; return the seconds until another answers."""
    container = await killed(rest, robot)
    began = time.monotonic()
    replaced = await another(rest, container["robot"], container)
    assert replaced["machine"] == container["machine"]
    return time.monotonic() - began


async def killed(rest: RestClient, robot: str) -> dict[str, Any]:
    """Kill and return the current container of a robot; a busy host may have replaced the earlier one."""
    async with patience(HERE):
        while True:
            container = (await containers(rest)).get(robot)
            with contextlib.suppress(ProcessLookupError):
                if container is not None:
                    os.kill(container["pid"], signal.SIGKILL)
                    return container
            await asyncio.sleep(0.05)


async def lose(rest: RestClient, node: RayNode, container: dict[str, Any]) -> float:
    """Cut the power of a node; return the seconds until its robot is served by another."""
    began = time.monotonic()
    await asyncio.to_thread(node.end)
    replaced = await another(rest, container["robot"], container)
    assert replaced["machine"] != container["machine"]
    return time.monotonic() - began


async def join_and_take_over(rest: RestClient, cluster: RayCluster, old: RayNode) -> None:
    """Let a node join and the old one leave like by ``ray stop``: the new one takes over the containers."""
    (before,) = await rest.items("/v1/machines")
    await asyncio.to_thread(cluster.join, "--labels=host=new")
    machines = await machines_when(rest, lambda all_: len(all_) == 2)
    (new,) = [machine["id"] for machine in machines if machine["id"] != before["id"]]
    carried = await containers(rest)
    assert {container["machine"] for container in carried.values()} == {before["id"]}
    await asyncio.to_thread(old.leave)
    for robot, container in carried.items():
        assert (await another(rest, robot, container))["machine"] == new


async def wait_until_nothing_is_left(cluster: RayCluster) -> None:
    """Wait until no process of the cloud is left on the nodes; Ray ends its actors a moment later."""
    for node in cluster.nodes:
        await until(lambda node=node: not node.find("engine.") and not node.find("ray::AgentActor"), HERE)  # type: ignore[misc]


async def back(rest: RestClient, node: RayNode, before: psutil.Process) -> dict[str, Any]:
    """Return the machine of a node once another agent has registered it."""
    await until(lambda: has_ended(before.pid), HERE)
    await until(lambda: node.find(agent.__name__), HERE)
    (machine,) = await machines_when(rest, len)
    return machine


async def test_killed_processes_of_nodes_and_watcher_are_restarted(
    tmp_path: Path, cluster: RayCluster, office_map: GridMap
) -> None:
    node = cluster.join()
    with running_cloud(tmp_path, *on_ray(cluster)) as cloud:
        rest = await cloud.admin()
        (machine,) = await machines_when(rest, len)
        await publish_map(rest, "office-1", office_map)
        (watcher,) = cloud.find(WATCHER)
        watcher.kill()
        for victim in (agent.__name__, "ray::AgentActor"):
            before = node.agent()
            max(node.find(victim), key=lambda process: process.create_time()).kill()
            again = await back(rest, node, before)
            assert again["id"] == machine["id"], "it is the same node"
        before = node.agent()
        before.suspend()  # it sends no heartbeats
        await back(rest, node, before)
        assert len(cloud.find(WATCHER)) == 1
        start = free_pose(office_map, seed=3)
        answer = await rest.plan("office-1", start, reachable_pose(office_map, start, seed=4, at_least=4.0))
        assert answer["plan_id"]
        node.raylet().kill()  # Ray kills its child processes
        await machines_when(rest, lambda all_: not all_)
        await asyncio.to_thread(cluster.join)
        (other,) = await machines_when(rest, len)
        assert other["id"] != machine["id"], "another node, which removes the remains of the killed agent"


async def test_a_killed_cloud_finds_its_nodes_again(tmp_path: Path, cluster: RayCluster) -> None:
    node = cluster.join()
    arguments = on_ray(cluster, free_ports(2)[0])
    with running_cloud(tmp_path, *arguments) as cloud:
        await machines_when(await cloud.admin(), len)
        agent = node.agent().pid
        os.kill(cloud.pid, signal.SIGKILL)
        cloud.status = -signal.SIGKILL
        (tmp_path / "ready.json").unlink()
        cloud.children = list  # type: ignore[method-assign, assignment]  # they have exited, or are not its children
    with running_cloud(tmp_path, *arguments) as again:
        await machines_when(await again.admin(), len)
        assert node.agent().pid == agent
    await wait_until_nothing_is_left(cluster)


OTHER_WORK = """
import sys
import ray
class Work:
    def has_begun(self): return True
ray.init(sys.argv[1], namespace="others", log_to_driver=False, _node_ip_address=sys.argv[1].partition(":")[0])
work = ray.remote(Work).options(name="work", lifetime="detached", num_cpus=2).remote()
assert ray.get(work.has_begun.remote())
"""


async def test_a_machine_has_the_cores_that_other_work_of_ray_leaves(tmp_path: Path, cluster: RayCluster) -> None:
    cluster.join(cores=3)
    others = [sys.executable, "-c", OTHER_WORK, cluster.address]
    await asyncio.to_thread(subprocess.run, others, check=True, timeout=HERE)
    with running_cloud(tmp_path, *on_ray(cluster)) as cloud:
        (machine,) = await machines_when(await cloud.admin(), len)
        assert machine["cores"] == 1
    await wait_until_nothing_is_left(cluster)


def test_a_wrong_cluster_token_is_reported(
    tmp_path: Path, cluster: RayCluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    wrong = tmp_path / "wrong"
    wrong.write_text("0" * 64)
    monkeypatch.setenv("RAY_AUTH_TOKEN_PATH", str(wrong))
    up = Up(tmp_path, *on_ray(cluster))
    assert up.wait() == 1
    assert "RAY_AUTH_TOKEN_PATH" in up.log.read_text()
