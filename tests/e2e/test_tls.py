"""A cloud that serves HTTPS with a certificate of an authority of the test."""

import asyncio
import json
import sys
from pathlib import Path
from typing import Any

import pytest

from benchmarks.harness.free_ports import free_ports
from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from robots import cli
from robots.client.rest import RestClient
from tests.support.clients.rce import rce_robot
from tests.support.cloud.cloud import ADMIN_PASSWORD, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import driving
from tests.support.network.certificates import TestAuthority
from tests.support.ros2.bridge_process import bridge_process
from tests.support.ros2.zenoh_robot import free_endpoint, zenoh_robot
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

PASSWORD_OF_2013 = "the robots of 2013"


async def ppaas(*arguments: str, stdin: str = "") -> tuple[int, str, str]:
    """Run a command; return its status, output and errors."""
    command = (sys.executable, "-m", cli.__name__, *arguments)
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), asyncio.subprocess.PIPE)
    process = await asyncio.create_subprocess_exec(*command, **pipes)  # type: ignore[arg-type]
    out, errors = await process.communicate(stdin.encode())
    return process.returncode or 0, out.decode(), errors.decode()


async def drive_by_ros2(url: str, token: str, authority: TestAuthority, grid: GridMap, start: Pose2D) -> None:
    """Drive a robot with ROS 2 over Zenoh, with TLS on both sides of its bridge."""
    endpoint, folder = free_endpoint().replace("tcp/", "tls/"), authority.file.parent
    certificate, key = authority.issue("bridge")
    config = folder / "zenoh.json5"
    tls = {"listen_certificate": str(certificate), "listen_private_key": str(key)}
    config.write_text(json.dumps({"transport": {"link": {"tls": tls}}}))
    options = ("--transport", "zenoh", "--listen", endpoint, "--zenoh-config", str(config), "--url", url)
    with bridge_process("tb2", *options, "--token", token, log=folder / "bridge.log"):
        async with zenoh_robot(endpoint, grid, start, authority=authority.file) as robot:
            goal = reachable_pose(grid, start, seed=3, at_least=1.0, at_most=2.0)
            await robot.send_goal(goal)
            await robot.arrives(goal)


async def hear_as_in_2013(url: str, master: str, admin: RestClient, grid: GridMap, start: Pose2D) -> None:
    """Receive a map as a robot of Rapyuta, by the master's HTTPS and the WebSocket that it names."""
    await admin.post("/v1/users", {"id": "ann", "password": ADMIN_PASSWORD})
    await admin.patch("/v1/users/ann", {"rapyuta_password": PASSWORD_OF_2013})
    ann = RestClient(url)
    await ann.login("ann", ADMIN_PASSWORD)
    await publish_map(ann, "office2013", grid)
    await register_robot(ann, "tb2013", "office2013", start)
    maps: list[Any] = []
    async with rce_robot(master, "ann", "tb2013", PASSWORD_OF_2013) as robot:
        await robot.create_container("c1")
        await robot.add_interface("c1", "map", "SubscriberInterface", "nav_msgs/OccupancyGrid", "/map")
        await robot.add_interface("tb2013", "map", "PublisherConverter", "nav_msgs/OccupancyGrid")
        robot.on("map", lambda _kind, _id, message: maps.append(message))
        await robot.add_connection("tb2013/map", "c1/map")
        await until(lambda: maps)
        assert robot.errors == []
    assert len(maps[0]["data"]) == grid.data.size


async def test_robots_programs_and_commands_use_a_cloud_by_tls(
    tmp_path: Path, office_map: GridMap, monkeypatch: pytest.MonkeyPatch
) -> None:
    authority = TestAuthority(tmp_path)
    certificate, key = authority.issue("cloud")
    [rapyuta] = free_ports(1)
    options = ("--tls-cert", str(certificate), "--tls-key", str(key), "--rapyuta", str(rapyuta))
    with running_cloud(tmp_path, *options) as cloud:
        assert cloud.url.startswith("https://127.0.0.1:")
        with pytest.raises(Unavailable, match=r"its certificate is not trusted .* by --ca-file or SSL_CERT_FILE"):
            await RestClient(cloud.url).login("admin", ADMIN_PASSWORD)

        login = ("login", "admin", "--url", cloud.url, "--ca-file", str(authority.file))
        status, token, errors = await ppaas(*login, stdin=ADMIN_PASSWORD + "\n")
        assert (status, errors) == (0, "")

        monkeypatch.setenv("SSL_CERT_FILE", str(authority.file))
        rest = await cloud.admin()
        await publish_map(rest, "office", office_map)
        start = free_pose(office_map, seed=1)
        robot = await register_robot(rest, "tb1", "office", start)
        async with driving(cloud.url, robot, "tb1", office_map, start) as drive:
            authority.issue("cloud")
            assert await drive.go(reachable_pose(office_map, start, seed=2, at_least=1.5)) <= 0.25
        await hear_as_in_2013(cloud.url, f"https://127.0.0.1:{rapyuta}/", rest, office_map, start)

        await drive_by_ros2(cloud.url, await register_robot(rest, "tb2", "office", start), authority, office_map, start)

        monkeypatch.setenv("PPAAS_TOKEN", token.strip())
        status, events, errors = await ppaas("audit", "--url", cloud.url, "--user", "admin", "--json")
        assert (status, errors) == (0, "")
        found = {(event["action"], event["object"], event["outcome"]) for event in json.loads(events)}
        assert found >= {
            ("log_in", "users/admin", "ok"),
            ("publish_map", "maps/office", "ok"),
            ("put_robot", "robots/tb1", "ok"),
            ("connect", "robots/tb1", "ok"),
            ("disconnect", "robots/tb1", "ok"),
        }
        assert ADMIN_PASSWORD not in events
        assert token.strip() not in (tmp_path / "data" / "audit.jsonl").read_text()
