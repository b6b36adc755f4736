"""A robot of the cloud follows paths of Open-RMF, which a node with types of Cyclone DDS plays."""

import asyncio
import json
import math
import os
import sys
from pathlib import Path

import pytest
import yaml

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.wire.rmf.fleet_robot import RmfMode
from ppaas.wire.rmf.level_frame import LevelFrame
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.ros2.bridge_process import COMMAND, bridge_process
from tests.support.ros2.rmf_peer import Location, RmfPeer
from tests.support.sources import ROOT
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

DOMAIN = 83
ROS = ROOT / "build" / "ros" / "kilted" / "bin" / "python"
MESSAGES = ROOT / "build" / "ros" / "kilted_messages"
SCRIPT = ROOT / "tests" / "support" / "ros2" / "rclpy_rmf.py"
FRAME = LevelFrame(scale=1.0, rotation=math.pi / 2, x=100.0, y=-50.0)


def location(pose: Pose2D) -> Location:
    x, y, yaw = FRAME.to_rmf(pose)
    return Location(x=x, y=y, yaw=yaw, level_name="L1")


def reference_points(file: Path) -> Path:
    robot = [[0.0, 0.0], [10.0, 0.0], [10.0, 8.0]]
    rmf = [list(FRAME.to_rmf(Pose2D(*place))[:2]) for place in robot]
    file.write_text(yaml.safe_dump({"reference_coordinates": {"L1": {"rmf": rmf, "robot": robot}}}))
    return file


async def test_a_robot_follows_a_path_of_rmf(
    cloud: RunningCloud, office_map: GridMap, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=60)
    between = reachable_pose(office_map, start, seed=61, at_least=0.6, at_most=1.2)
    goal = reachable_pose(office_map, between, seed=62, at_least=0.6, at_most=1.2)
    token = await register_robot(rest, "rmf1", "office", start)
    options = ("rmf1", "--fleet", "carts", "--name", "rmf1=cart", "--level", "office=L1", "--domain", str(DOMAIN))
    options += ("--transform", str(reference_points(tmp_path / "points.yaml")), "--url", cloud.url, "--token", token)
    command = (*COMMAND[:-1], "rmf")
    async with driving(cloud.url, token, "rmf1", office_map, start) as drive:
        with bridge_process(*options, command=command, log=tmp_path / "log", env=os.environ):
            rmf = RmfPeer(DOMAIN, "carts")
            await until(lambda: "cart" in rmf.look())
            place = rmf.robots["cart"].location
            expected = FRAME.to_rmf(start)
            assert math.dist((place.x, place.y), expected[:2]) < 0.3
            assert (place.level_name, rmf.robots["cart"].battery_percent) == ("L1", 100.0)
            async with patience(100.0):
                await rmf.follow("cart", [location(pose) for pose in (start, between, goal)])
                assert rmf.robots["cart"].mode.mode == RmfMode.MOVING
                remaining = await rmf.finished("cart")
            assert remaining == sorted(remaining, reverse=True) and {2, 1, 0} <= {*remaining}
            assert drive.scorer.error(0, goal) < 0.3
            assert rmf.robots["cart"].mode.mode == RmfMode.IDLE
            async with patience(60.0):
                await rmf.follow("cart", [location(start)])
                await rmf.set_mode("cart", RmfMode.PAUSED)
                await until(lambda: rmf.look()["cart"].mode.mode == RmfMode.PAUSED)
                assert len(rmf.robots["cart"].path) == 1
                await rmf.follow("cart", [location(Pose2D(-20.0, -20.0))])
                await rmf.set_mode("cart", RmfMode.MOVING)
                await until(lambda: rmf.look()["cart"].mode.mode == RmfMode.ADAPTER_ERROR)
    log = (tmp_path / "log").read_text()
    assert "level L1: scale 1.0000, turned by 1.5708 rad, residual 0.000 m" in log
    assert "robot cart is in the fleet" in log
    assert "does not reach its waypoint" in log


@pytest.mark.ros
async def test_rmf_on_rclpy_sends_a_robot_along_a_path(
    cloud: RunningCloud, office_map: GridMap, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    packages = MESSAGES / "lib" / f"python{sys.version_info.major}.{sys.version_info.minor}" / "site-packages"
    if not (packages / "rmf_fleet_msgs").is_dir():
        pytest.skip("rmf_fleet_msgs for ROS 2 is not built: run make test-ros")
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(DOMAIN + 1))
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=60)
    goal = reachable_pose(office_map, start, seed=61, at_least=0.6, at_most=1.2)
    token = await register_robot(rest, "rmf2", "office", start)
    options = ("rmf2", "--fleet", "carts", "--url", cloud.url, "--token", token)
    env = os.environ | {
        "PYTHONPATH": str(packages),
        "LD_LIBRARY_PATH": str(MESSAGES / "lib"),
        "AMENT_PREFIX_PATH": f"{MESSAGES}:{ROS.parent.parent}",
    }
    async with driving(cloud.url, token, "rmf2", office_map, start) as drive:
        with bridge_process(*options, command=(*COMMAND[:-1], "rmf"), log=tmp_path / "log", env=os.environ):
            path = json.dumps([list(start), list(goal)])
            rmf = await asyncio.create_subprocess_exec(
                ROS, SCRIPT, "carts", "rmf2", path, "office", env=env, stdout=asyncio.subprocess.PIPE
            )
            printed, _ = await asyncio.wait_for(rmf.communicate(), 150.0)
        assert drive.scorer.error(0, goal) < 0.3
    found = json.loads(printed)
    assert found["remaining"] == sorted(found["remaining"], reverse=True) and found["remaining"][-2:] == [1, 0]
    assert math.dist(found["place"], goal[:2]) < 0.3
    assert (found["level"], found["battery"], found["in_order"]) == ("office", 100.0, True)
