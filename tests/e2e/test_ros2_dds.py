"""A robot on rclpy and Fast DDS drives to a goal by its clone, with a bridge between them, over DDS and by rclpy.

``make test-ros`` installs ROS 2. All nodes are on the loopback interface.
"""

import asyncio
import json
import math
import os
import socket
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import psutil
import pytest

from ppaas.maps.grid import GridMap
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.ros2.bridge_process import COMMAND, bridge_process
from tests.support.sources import ROOT
from tests.support.world.places import free_pose, reachable_pose

pytestmark = [pytest.mark.journey, pytest.mark.ros]

ENVIRONMENTS = ROOT / "build" / "ros"
ROS = ENVIRONMENTS / "kilted" / "bin" / "python"
SCRIPTS = ROOT / "tests" / "support" / "ros2"
MESSAGES = ROOT / "build" / "ros" / "kilted_messages"
DOMAIN = "37"
REACHED, CANCELLED, ABORTED = 4, 5, 6
"""Statuses of ``action_msgs/GoalStatus``."""

NO_VALID_GRAPH = 402
"""``error_code`` of ``nav2_msgs/ComputeRoute`` on a map without lanes."""

MEMORY = 60 << 20
"""Largest memory of a bridge without rclpy [bytes]."""


@dataclass(frozen=True)
class Way:
    """Transport of a bridge, its command, the release of the robot's ROS, and whether nodes ask a discovery server."""

    transport: str
    command: tuple[str | Path, ...]
    env: Mapping[str, str] = field(default_factory=dict)
    release: str = "kilted"
    server: bool = False


WAYS = {
    "dds": Way("dds", COMMAND),
    "dds-jazzy": Way("dds", COMMAND, release="jazzy"),
    "rclpy": Way("rclpy", (ROS, "-m", "tests.support.ros2.rclpy_bridge"), {"PYTHONPATH": str(ROOT)}),
    "rclpy-server": Way(
        "rclpy", (ROS, "-m", "tests.support.ros2.rclpy_bridge"), {"PYTHONPATH": str(ROOT)}, server=True
    ),
}


@contextmanager
def discovery_server() -> Iterator[dict[str, str]]:
    """Run a discovery server of Fast DDS; yield the variable by which nodes find each other by it alone."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        root, port = ROS.parent.parent, free.getsockname()[1]
    libraries = root / "lib" / f"python{sys.version_info.major}.{sys.version_info.minor}" / "site-packages"
    env = os.environ | {"LD_LIBRARY_PATH": f"{root / 'lib'}:{libraries / 'ros_fastdds.libs'}"}
    command = (root / "bin" / "fast-discovery-server", "42", "-i", "0", "-l", "127.0.0.1", "-p", str(port))
    process = subprocess.Popen(command, env=env, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
    try:
        yield {"ROS_DISCOVERY_SERVER": f"127.0.0.1:{port}"}
    finally:
        process.kill()
        process.wait()


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as made:
        yield made


@pytest.mark.parametrize("name", WAYS)
async def test_a_robot_on_rclpy_is_driven(
    name: str, cloud: RunningCloud, office_map: GridMap, tmp_path: Path, stack: ExitStack
) -> None:
    rest, way = await cloud.admin(), WAYS[name]
    ros = ENVIRONMENTS / way.release / "bin" / "python"
    if not ros.exists():
        pytest.skip("ROS 2 is not installed: run make test-ros")
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=31)
    goal = reachable_pose(office_map, start, seed=32, at_least=1.5, at_most=3.0)
    token = await register_robot(rest, name, "office", start)
    np.savez(tmp_path / "grid.npz", grid=office_map.data)
    env = os.environ | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": DOMAIN}
    if way.server:
        env |= stack.enter_context(discovery_server())
    options = (name, "--transport", way.transport, "--url", cloud.url, "--token", token)
    with bridge_process(*options, command=way.command, log=tmp_path / "log", env=env | way.env) as bridge:
        numbers = [str(number) for number in (*start, goal.x, goal.y)]
        robot = await asyncio.create_subprocess_exec(
            ros, SCRIPTS / "rclpy_robot.py", tmp_path / "grid.npz", *numbers, env=env, stdout=asyncio.subprocess.PIPE
        )
        printed, _ = await asyncio.wait_for(robot.communicate(), 100)
        memory = psutil.Process(bridge.pid).memory_info().rss
    arrived = json.loads(printed)
    assert math.dist(arrived["pose"][:2], (goal.x, goal.y)) < 0.3
    assert arrived["map"] == 1
    assert arrived["plan"]
    assert "ppaas_bridge" in arrived["nodes"]
    log = (tmp_path / "log").read_text()
    if way.transport == "dds":
        assert "offers no actions" in log
        assert arrived["served"] == []
        assert memory <= MEMORY
    else:
        [absent] = [line for line in log.splitlines() if "are not offered: the robot's ROS has no package" in line]
        assert "'wait'" in absent
        assert "'undock_robot' are not offered" in absent
        assert arrived["served"] == [office_map.info.width, office_map.info.height]


async def test_a_client_of_navigation2_on_rclpy_is_answered_by_the_clone(
    cloud: RunningCloud, office_map: GridMap, tmp_path: Path
) -> None:
    if not MESSAGES.exists():
        pytest.skip("nav2_msgs for ROS 2 is not built: run make test-ros")
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=31)
    goal = reachable_pose(office_map, start, seed=32, at_least=1.5, at_most=3.0)
    token = await register_robot(rest, "nav2", "office", start)
    np.savez(tmp_path / "grid.npz", grid=office_map.data)
    packages = MESSAGES / "lib" / f"python{sys.version_info.major}.{sys.version_info.minor}" / "site-packages"
    env = os.environ | {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": DOMAIN,
        "ROS_DISTRO": "kilted",
        "PYTHONPATH": f"{ROOT}:{packages}",
        "LD_LIBRARY_PATH": str(MESSAGES / "lib"),
        "AMENT_PREFIX_PATH": f"{MESSAGES}:{ROS.parent.parent}",
    }
    options = ("nav2", "--transport", "rclpy", "--url", cloud.url, "--token", token)
    with bridge_process(*options, command=WAYS["rclpy"].command, log=tmp_path / "log", env=env):
        numbers = [str(number) for number in (*start, goal.x, goal.y)]
        robot = await asyncio.create_subprocess_exec(
            ROS,
            SCRIPTS / "rclpy_navigator.py",
            tmp_path / "grid.npz",
            *numbers,
            env=env,
            stdout=asyncio.subprocess.PIPE,
        )
        printed, _ = await asyncio.wait_for(robot.communicate(), 350)
    ended = json.loads(printed)
    assert (ended["path"]["status"], ended["path"]["code"]) == (REACHED, 0)
    assert ended["path"]["end"] > 10
    assert (ended["reached"]["status"], ended["reached"]["code"]) == (REACHED, 0)
    assert math.dist(ended["reached"]["end"][:2], (goal.x, goal.y)) < 0.3
    assert ended["feedbacks"] > 2
    assert ended["cancelled"]["status"] == CANCELLED
    assert ended["blocked"]["status"] == ABORTED
    assert ended["blocked"]["code"] > 0
    assert ended["blocked"]["end"], "the error has words"
    assert ended["valid"]
    assert (ended["followed"]["status"], ended["followed"]["code"]) == (REACHED, 0)
    assert math.dist(ended["followed"]["end"][:2], start[:2]) < 0.3
    assert (ended["route"]["status"], ended["route"]["code"]) == (ABORTED, NO_VALID_GRAPH)
    assert ended["route"]["end"] == "the map has no lanes: draw zones of the kind 'lane'"
    assert ended["tour"]["end"] == [1], "the waypoint in the wall was missed"
    assert "map → odom" in ended["frames"]
