"""The examples of plug-ins are installed together like any distributions, and one cloud uses them all."""

import asyncio
import importlib.util
import json
import math
import os
import socket
import subprocess
import sys
import sysconfig
import tomllib
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import psutil
import pytest

from engine.master.balancer import Balancer
from engine.master.machine import Machine
from engine.specs.containers import ContainerSpec, MapVersion
from ppaas.errors import NotPermitted
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.nav_msgs import Odometry
from ppaas.people.rules.base import Candidate, PeopleRule
from ppaas.plugins import PluginRegistry
from robots import cli
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from tests.support.cloud.cloud import RunningCloud, publish_map, running_cloud
from tests.support.cloud.drive import Drive, driving
from tests.support.documents import blocks
from tests.support.installed_packages import install
from tests.support.sources import ROOT
from tests.support.waiting import until
from tests.support.world.planar_world import walled_map

EXAMPLES = ROOT / "docs" / "examples"
NAMES = (
    "pursuit_controller", "creep_recovery", "nice_runtime", "fewest_balancer", "counting_store", "udp_bridge",
    "newest_rule",
)  # fmt: skip
ENTRIES = {
    f"{group}:{entry}"
    for name in NAMES
    for group, entries in tomllib.loads((EXAMPLES / name / "pyproject.toml").read_text())["project"][
        "entry-points"
    ].items()
    for entry in entries
}
MOST_LINES = 60

QUOTED = {
    "local-planners": "class Controller", "planning": "class Recovery", "stores": "class Backend",
    "engine": "class Balancer", "machines": "class Runtime", "robots": "HELP: str",
}  # fmt: skip
INTERFACES = {
    "local-planners": "ppaas/controllers/base.py", "planning": "ppaas/recoveries/base.py",
    "stores": "storage/urls/base.py", "engine": "engine/master/balancer.py", "machines": "engine/runtimes/base.py",
    "robots": "robots/bridges/cli/ros1.py",
}  # fmt: skip
"""Sources of the interfaces that the pages quote; that of rules is the example itself."""

CLOSET = [(5.5, 3.5, 7.5, 3.6), (5.5, 5.4, 7.5, 5.5), (5.5, 3.5, 5.6, 5.5), (7.4, 3.5, 7.5, 5.5)]
"""Walls of a room whose door is shut."""

SHUT = walled_map(8, 6, CLOSET)
HALL = walled_map(8, 6, [(5.5, 3.5, 6.0, 3.6), (7.0, 3.5, 7.5, 3.6), *CLOSET[1:]])
START, BEHIND_A_CORNER = Pose2D(1.5, 1.5), Pose2D(4.5, 4.5, 1.0)
BEFORE_THE_DOOR, IN_THE_CLOSET = Pose2D(6.5, 2.4, math.pi / 2), Pose2D(6.5, 4.5)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder that has all packages; those that this environment lacks are installed into it."""
    if all(importlib.util.find_spec(name) for name in NAMES):
        return Path(sysconfig.get_path("purelib"))
    target = tmp_path_factory.mktemp("plugins")
    install(target, *(EXAMPLES / name for name in NAMES))
    return target


@pytest.fixture(scope="module")
def environment(folder: Path) -> Iterator[dict[str, str]]:
    """Let processes that are started find the packages."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", os.pathsep.join((str(folder), str(ROOT))))
        yield dict(os.environ)


@pytest.fixture(scope="module")
def cloud(tmp_path_factory: pytest.TempPathFactory, environment: dict[str, str]) -> Iterator[RunningCloud]:
    """Return a cloud with the store, the runtime and the balancer."""
    data = tmp_path_factory.mktemp("cloud")
    allowed = [word for entry in ENTRIES for word in ("--allow", entry)]
    chosen = ["--store", f"counting://{data}/store.sqlite", "--runtime", "nice", "--balancer", "fewest"]
    with running_cloud(data, "--linger", "0.2", *chosen, *allowed) as running:
        yield running
    assert "counting_store: the store was called" in running.log.read_text()


@asynccontextmanager
async def connected(cloud: RunningCloud, robot: str, start: Pose2D) -> AsyncIterator[Drive]:
    """Connect a simulated Turtlebot with the local planner and the recovery behaviour; the map has the door open."""
    rest = await cloud.admin()
    await publish_map(rest, "hall", HALL)
    parameters: dict[str, Any] = {
        "move_base": {"planner_patience": 0.5, "recovery_behaviors": [{"name": "back", "type": "creep"}]},
        "pursuit": {"lookahead": 0.4},
        "back": {"distance": 0.3},
    }
    file = RobotFile(map="hall", initial_pose=start, base_local_planner="pursuit", parameters=parameters)
    await rest.put_robot(robot, file)
    assert rest.token is not None
    async with driving(cloud.url, rest.token, robot, SHUT, start) as drive:
        yield drive


@pytest.mark.parametrize("name", NAMES)
def test_an_example_is_short_and_uses_public_names(name: str) -> None:
    [file] = (EXAMPLES / name).glob("*.py")
    lines = file.read_text().splitlines()
    assert len(lines) <= MOST_LINES
    assert not [line for line in lines if "import" in line.split(" ") and " _" in line]


@pytest.mark.parametrize(("page", "interface"), sorted(INTERFACES.items()))
def test_the_pages_quote_the_interfaces_of_the_code(page: str, interface: str) -> None:
    [quoted] = [block for block in blocks(f"docs/{page}.md", "python") if QUOTED[page] in block]
    code = (ROOT / interface).read_text().replace('"""', "")
    lines = [line.removesuffix(" ...") for line in quoted.splitlines() if ": ..." in line or line.startswith("class")]
    assert lines
    assert [line for line in lines if line not in code] == []


@pytest.mark.journey
async def test_a_robot_reaches_its_goal_with_the_plugins(cloud: RunningCloud) -> None:
    async with connected(cloud, "pursuer", START) as drive:
        assert await drive.go(BEHIND_A_CORNER) <= 0.25
        assert drive.scorer.collisions(0) == 0
        assert cloud.container().nice() == min(cloud.agent().nice() + 5, 19)


@pytest.mark.journey
async def test_the_recovery_behaviour_runs_before_a_door_that_is_shut(cloud: RunningCloud) -> None:
    async with connected(cloud, "creeper", BEFORE_THE_DOOR) as drive:
        await drive.send(IN_THE_CLOSET)
        await until(lambda: any(twist.linear.x < 0.0 for _, twist in drive.commands), timeout=30.0)
        before = drive.world.robots[0].base.pose
        result = await drive.result()
        assert result.status.status == Status.ABORTED, result.status.text
        moved = before.inverse() @ drive.world.robots[0].base.pose
        assert -0.4 < moved.x < -0.2
        assert abs(moved.y) < 0.1


@pytest.mark.journey
async def test_a_rule_is_chosen_by_its_name(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "hall", HALL)
    changed = await rest.patch("/v1/maps/hall/people/settings", {"rule": "newest"})
    assert changed["rule"] == "newest"
    assert "newest" in (await rest.get("/v1/maps/hall/people"))["rules"]


@pytest.mark.journey
async def test_the_bridge_forwards_odometry_and_velocities(cloud: RunningCloud, environment: dict[str, str]) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "hall", HALL)
    await rest.put_robot("board", RobotFile(map="hall", initial_pose=START))
    assert rest.token is not None
    poses: list[Odometry] = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as board:
        board.bind(("127.0.0.1", 0))
        board.setblocking(False)
        async with (
            _bridge(cloud, rest.token, environment) as address,
            RobotClient(cloud.url, robot="board", token=rest.token, role="operator") as operator,
            asyncio.timeout(30.0),
        ):
            await operator.subscribe("odom", Odometry, poses.append)
            while not poses:
                board.sendto(b"[1.5, 0.25, 0.0, 0.3, 0.0]", address)
                board.sendto(b"no odometry", address)
                await asyncio.sleep(0.1)
            await operator.publish("cmd_vel", Twist(Vector3(x=0.125), Vector3(z=-0.5)))
            while json.loads(await asyncio.get_running_loop().sock_recv(board, 1000)) != [0.125, -0.5]:
                pass
    assert (poses[0].pose.pose.planar(), poses[0].twist.twist.linear.x) == (Pose2D(1.5, 0.25), 0.3)


@asynccontextmanager
async def _bridge(cloud: RunningCloud, token: str, environment: dict[str, str]) -> AsyncIterator[tuple[str, int]]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        address: tuple[str, int] = free.getsockname()
    command = [sys.executable, "-m", cli.__name__, "bridge", "udp", "board", "--url", cloud.url]
    options = ["--token", token, "--port", str(address[1])]
    bridge = await asyncio.create_subprocess_exec(*command, *options, env=environment)
    try:
        await until(lambda: bridge.returncode is not None or _listens(bridge.pid))
        yield address
    finally:
        bridge.terminate()
        await bridge.wait()


def _listens(pid: int) -> bool:
    return any(each.type == socket.SOCK_DGRAM for each in psutil.Process(pid).net_connections())


def test_the_balancer_chooses_the_machine_with_the_fewest_containers(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(folder)
    balancers: PluginRegistry[Balancer] = PluginRegistry("ppaas.balancers", "balancer", Balancer, {})  # type: ignore[type-abstract]
    balancer = balancers.create("fewest", {})
    few, many = Machine("few", 4, 1 << 34, 1), Machine("many", 4, 1 << 34, 2)
    spec = ContainerSpec("c", "ann", MapVersion("hall", "1"), 1.0)
    for machine in (many, few):
        balancer.joined(machine)
    many.place(spec)
    assert balancer.choose(spec) is few
    few.settings = type(few.settings)(draining=True)
    assert balancer.choose(spec) is many


def test_the_rule_follows_those_who_came_last(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(folder)
    rules: PluginRegistry[PeopleRule] = PluginRegistry("ppaas.people_rules", "rule", PeopleRule, {})  # type: ignore[type-abstract]
    people = [Candidate(1, first_seen=5.0), Candidate(2, first_seen=9.0), Candidate(3, followed=True)]
    assert rules.create("newest", {}).choose(people, [], 2) == [3, 2]


@pytest.mark.parametrize(
    ("option", "value", "entry"),
    [
        ("--store", "counting:store.sqlite", "ppaas.stores:counting"),
        ("--runtime", "nice", "ppaas.runtimes:nice"),
        ("--balancer", "fewest", "ppaas.balancers:fewest"),
    ],
)
def test_a_cloud_refuses_what_is_not_allowed_and_names_the_option(
    tmp_path: Path, environment: dict[str, str], option: str, value: str, entry: str
) -> None:
    command = [sys.executable, "-m", cli.__name__, "up", "--port", "0", "--data", str(tmp_path / "data"), option, value]
    ended = subprocess.run(command, cwd=tmp_path, env=environment,
                           capture_output=True, text=True, timeout=60, check=False)  # fmt: skip
    assert ended.returncode == 1
    assert f"ppaas: {NotPermitted.slug}:" in ended.stderr
    assert f"ppaas up --allow {entry}" in ended.stderr


def test_the_rule_of_the_page_is_the_example() -> None:
    [quoted] = [block for block in blocks("docs/people.md", "python") if "class Newest" in block]
    assert quoted.strip() in (EXAMPLES / "newest_rule" / "newest_rule.py").read_text()
