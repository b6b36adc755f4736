"""A robot on rospy drives to a goal of actionlib by its clone, with a bridge between them.

``make test-ros`` installs ROS 1 of Debian in a chroot. Bridge and master are killed on the way.
"""

import asyncio
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import uuid
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import psutil
import pytest

from benchmarks.harness.free_ports import free_ports
from ppaas.maps.grid import GridMap
from robots import cli
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.ros2.bridge_process import bridge_process
from tests.support.sources import ROOT
from tests.support.waiting import patience
from tests.support.world.places import free_pose, reachable_pose

pytestmark = [pytest.mark.journey, pytest.mark.ros]

ROS = ROOT / "build" / "ros" / "noetic"
SUPPORT = ROOT / "tests" / "support"
SCRIPTS = (SUPPORT / "ros1" / "rospy_robot.py", SUPPORT / "ros2" / "grid_robot.py")
CHROOT = ("/usr/sbin/chroot", ROS)
COMMAND = (sys.executable, "-m", cli.__name__, "bridge", "ros1")
SUCCEEDED, PREEMPTED = 3, 2
MEMORY = 60 << 20
"""Largest memory of a bridge [bytes]."""


@contextmanager
def rosmaster(port: int) -> Iterator[subprocess.Popen[bytes]]:
    process = subprocess.Popen([*CHROOT, "/usr/bin/rosmaster", "--core", "-p", str(port)], env=environment(port))
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def environment(port: int) -> dict[str, str]:
    return {
        "PATH": os.environ["PATH"],
        "HOME": "/tmp",
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_NAMESPACE": "/tb3",
    }


@contextmanager
def in_chroot(grid: GridMap) -> Iterator[str]:
    """Put the robot's scripts and the cells of a map into the chroot; return the path of their folder there."""
    name = f"tmp/{uuid.uuid4().hex}"
    (ROS / name).mkdir()
    try:
        for script in SCRIPTS:
            shutil.copy(script, ROS / name)
        np.savez(ROS / name / "grid.npz", grid=grid.data)
        yield f"/{name}"
    finally:
        shutil.rmtree(ROS / name)


async def prints(stream: asyncio.StreamReader, line: bytes, within: float) -> None:
    """Wait for a line among those that rospy adds: it warns while its master is not up yet."""
    async with patience(within):
        while await stream.readline() != line:
            assert not stream.at_eof(), f"the robot ended before it printed {line!r}"


async def test_a_robot_on_rospy_is_driven_while_bridge_and_master_are_killed(
    cloud: RunningCloud, office_map: GridMap, tmp_path: Path
) -> None:
    if not ROS.exists():
        pytest.skip("ROS 1 is not installed: run make test-ros as root, with mmdebstrap")
    rest, port = await cloud.admin(), free_ports(1)[0]
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=31)
    goal = reachable_pose(office_map, start, seed=32, at_least=1.5, at_most=3.0)
    token = await register_robot(rest, "rospy", "office", start)
    env = environment(port)
    options = ("rospy", "--url", cloud.url, "--token", token)
    numbers = [str(number) for number in (*start, goal.x, goal.y)]
    bridged = {"command": COMMAND, "env": os.environ | {"ROS_MASTER_URI": env["ROS_MASTER_URI"]}}
    with ExitStack() as masters, in_chroot(office_map) as folder:
        first = masters.enter_context(rosmaster(port))
        script = (f"{folder}/rospy_robot.py", f"{folder}/grid.npz", *numbers)
        robot = await asyncio.create_subprocess_exec(
            *CHROOT, "/usr/bin/python3", *script, env=env, stdout=subprocess.PIPE
        )
        assert robot.stdout is not None
        with bridge_process(*options, log=tmp_path / "killed", **bridged) as bridge:
            await prints(robot.stdout, b"map\n", within=60)
            bridge.send_signal(signal.SIGKILL)
        with bridge_process(*options, log=tmp_path / "log", **bridged) as bridge:
            await prints(robot.stdout, b"driving\n", within=90)
            first.send_signal(signal.SIGKILL)
            await asyncio.sleep(1.0)
            masters.enter_context(rosmaster(port))
            printed, _ = await asyncio.wait_for(robot.communicate(), 120)
            memory = psutil.Process(bridge.pid).memory_info().rss
    arrived = json.loads(printed.splitlines()[-1])  # rospy may have warned before
    assert (arrived["state"], arrived["cancelled"]) == (SUCCEEDED, PREEMPTED), arrived
    assert math.dist(arrived["pose"][:2], (goal.x, goal.y)) < 0.3
    assert arrived["served"] == [office_map.info.width, office_map.info.height]
    assert arrived["planned"] > 1
    assert arrived["map"] == 2, "each bridge publishes the map once"
    assert all(arrived[topic] for topic in ("cmd_vel", "plan", "tf", "feedback", "map_metadata")), arrived
    log = (tmp_path / "log").read_text()
    assert "the robot's namespace is /tb3" in log
    assert "the master does not answer, and is tried again" in log
    assert memory <= MEMORY
