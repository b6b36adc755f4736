"""``docker compose -f docker/compose.yaml``: it starts, robots drive in it, and its data survives."""

import asyncio
import json
import os
import subprocess
from collections.abc import Iterator

import pytest

from benchmarks.harness.free_ports import free_ports
from ppaas.maps.generate import office
from ppaas.messages.actionlib_msgs import Status
from robots.client.rest import RestClient
from tests.support.cloud.cloud import publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.engine.docker_engine import bring_up, run
from tests.support.sources import ROOT
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = [pytest.mark.docker, pytest.mark.timeout(1800)]

FILE = "docker/compose.yaml"
PROJECT = "ppaas-tests"
WAIT = "900"
"""Time limit until all services are healthy [s]."""

JOINED_WITHIN = 120.0

DEMO = [
    *("demo", "--headless", "--json", "--robots", "2", "--goals", "1", "--seed", "4"),
    *("--cloud", "http://proxy:8500", "--admin-password-file", "/run/ppaas/admin-password"),
]


class Compose:
    """One project of the compose file, at its own port."""

    def __init__(self, port: int) -> None:
        self.url = f"http://127.0.0.1:{port}"
        self._settings = {"PPAAS_PORT": str(port), "PPAAS_ROBOTS": "2", "PPAAS_GOALS": "1"}

    def __call__(self, *arguments: str) -> str:
        """Run a command of compose; return its output."""
        command = ["docker", "compose", "-p", PROJECT, "-f", FILE, *arguments]
        done = subprocess.run(
            command, cwd=ROOT, capture_output=True, text=True, env=os.environ | self._settings, check=False
        )
        assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}{done.stderr}{self._logs()}"
        return done.stdout

    def _logs(self) -> str:
        command = ["docker", "compose", "-p", PROJECT, "-f", FILE, "logs", "--tail", "20"]
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False).stdout[-6000:]

    def up(self, *services: str) -> None:
        """Start the named services, or all, and wait until they are healthy."""
        self("up", "--detach", "--wait", "--wait-timeout", WAIT, *services)

    async def admin(self) -> RestClient:
        """Log in with the password from the volume of the cloud."""
        client = RestClient(self.url)
        await client.login("admin", self("exec", "-T", "cloud", "cat", "/var/lib/ppaas/admin-password").strip())
        return client


@pytest.fixture(scope="module")
def compose() -> Iterator[Compose]:
    bring_up()
    [port] = free_ports(1)
    project = Compose(port)
    project("build")
    project.up()
    yield project
    project("--profile", "demo", "down", "--volumes", "--timeout", "20")
    left = run("docker", "ps", "--all", "--quiet", "--filter", f"label=com.docker.compose.project={PROJECT}")
    assert left == ""


async def test_stores_are_healthy_and_only_the_proxy_publishes_a_port(compose: Compose) -> None:
    rest = await compose.admin()
    assert (await rest.get("/v1/health"))["status"] == "ok"
    services = [json.loads(line) for line in compose("ps", "--format", "json").splitlines()]
    published = {service["Service"] for service in services if any(port["URL"] for port in service["Publishers"] or [])}
    assert published == {"proxy"}


async def test_robots_of_the_demo_reach_their_goals(compose: Compose) -> None:
    output = compose("--profile", "demo", "run", "--rm", "-T", "robots", *DEMO)
    report = json.loads(output.splitlines()[-1])
    assert [(robot["goals_reached"], robot["collisions"]) for robot in report["robots"]] == [(1, 0), (1, 0)]


async def test_machines_and_their_endpoints_join_and_a_killed_one_is_removed(compose: Compose) -> None:
    """A robot and its operator, at two of three endpoints behind one port, notice a killed machine by a pause only."""
    compose("up", "--detach", "--scale", "machine=2", "machine", "tickets")
    rest = await compose.admin()
    await there_are(rest, "/v1/machines", 3)
    await there_are(rest, "/v1/endpoints", 3)
    grid = office(seed=1, width=12.0, height=10.0)
    await publish_map(rest, "hall", grid)
    start = free_pose(grid, seed=2)
    goal = reachable_pose(grid, start, seed=3, at_least=3.0)
    token = await register_robot(rest, "tb0", "hall", start)
    async with driving(compose.url, token, "tb0", grid, start) as drive:
        await drive.send(goal, goal_id="far")
        await until(lambda: drive.scorer.distance(0) > 0.3, 60.0)
        run("docker", "rm", "--force", await machine_with_sockets(rest))
        result = await drive.result()
        assert (result.status.goal_id.id, result.status.status) == ("far", Status.SUCCEEDED), result.status.text
        assert drive.results.empty(), "one result a goal"
    await there_are(rest, "/v1/machines", 2)
    await there_are(rest, "/v1/endpoints", 2)
    compose("rm", "--stop", "--force", "machine")
    await there_are(rest, "/v1/machines", 1)


async def machine_with_sockets(rest: RestClient) -> str:
    """Return the host name of a machine whose endpoint has sockets, which is the id of its Docker container."""
    async with patience(JOINED_WITHIN):
        while True:
            for endpoint in await rest.items("/v1/endpoints"):
                if endpoint["sockets"] and endpoint["machine"] != "local":
                    return str(endpoint["machine"])
            await asyncio.sleep(0.5)


async def there_are(rest: RestClient, path: str, count: int) -> None:
    """Wait until the cloud lists ``count`` objects, besides machines that still start."""
    async with patience(JOINED_WITHIN):
        while sum(one.get("state") != "starting" for one in await rest.items(path)) != count:
            await asyncio.sleep(0.5)


async def test_data_survives_down_and_up(compose: Compose) -> None:
    rest = await compose.admin()
    grid = office(seed=1, width=12.0, height=10.0)
    await publish_map(rest, "office", grid)
    start = free_pose(grid, seed=1)
    goal = reachable_pose(grid, start, seed=2, at_least=3.0)
    planned = await rest.plan("office", (start.x, start.y), (goal.x, goal.y))
    compose("down", "--timeout", "20")
    compose.up()
    rest = await compose.admin()
    assert "office" in [found["id"] for found in await rest.items("/v1/maps")]
    assert planned["plan_id"] in [kept["plan_id"] for kept in await rest.items("/v1/maps/office/plans")]
    token = await register_robot(rest, "tb1", "office", start)
    async with driving(compose.url, token, "tb1", grid, start) as drive:
        assert await drive.go(goal) <= 0.25


def test_official_images_replace_those_of_the_project() -> None:
    bring_up()
    output = run("docker", "compose", "-f", FILE, "-f", "docker/compose.official.yaml", "config", "--format", "json")
    services = json.loads(output)["services"]
    official = {"cassandra": "cassandra", "namenode": "apache/hadoop", "datanode": "apache/hadoop", "proxy": "haproxy"}
    assert {name: services[name]["image"].partition(":")[0] for name in official} == official
    assert not any("build" in services[name] for name in official)
    assert "user=root" in " ".join(services["cloud"]["command"])
    assert services["namenode"]["user"] == "root"
