"""A robot with ROS 2 over Zenoh drives to a goal by its clone, with the bridge between them."""

import asyncio
import json
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages import encode
from ppaas.messages.geometry_msgs import Pose
from robots.client.rest import RestClient
from robots.demo.scorer import Scorer
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.ros2.bridge_process import bridge_process
from tests.support.ros2.zenoh_peer import LATCHED, Peer, Recorder
from tests.support.ros2.zenoh_robot import free_endpoint, zenoh_robot
from tests.support.sources import ROOT
from tests.support.waiting import patience
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

NAVIGATE = "nav2_msgs/action/NavigateToPose"
PLAN = "nav2_msgs/action/ComputePathToPose"
REACHED, CANCELLED = 4, 5
PYZEROS, CODECS = ROOT / "build/ros/pyzeros/bin/python", ROOT / "build/ros/pyzeros_codecs"


def stamped(pose: Pose2D) -> dict[str, Any]:
    return {"header": {"frame_id": "map"}, "pose": json.loads(encode(Pose.of(pose)))}


async def test_a_robot_with_ros_2_over_zenoh_plans_and_drives_by_the_actions_of_nav2(
    cloud: RunningCloud, office_map: GridMap, tmp_path: Path
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=31)
    goal = reachable_pose(office_map, start, seed=32, at_least=1.5, at_most=2.5)
    token = await register_robot(rest, "ros2", "office", start)
    endpoint = free_endpoint()
    options = ("--transport", "zenoh", "--listen", endpoint, "--url", cloud.url, "--token", token)
    with bridge_process("ros2", *options, log=tmp_path / "log"):
        async with zenoh_robot(endpoint, office_map, start, "/tb3_2") as both:
            feedback, grids, plans, frames = Recorder(), Recorder(), Recorder(), Recorder()
            both.operator.subscribe("navigate_to_pose/_action/feedback", f"{NAVIGATE}_FeedbackMessage", feedback)
            both.operator.subscribe("plan", "nav_msgs/msg/Path", plans)
            both.operator.subscribe("tf", "tf2_msgs/msg/TFMessage", frames)
            await asyncio.sleep(1.5)
            both.operator.subscribe("map", "nav_msgs/msg/OccupancyGrid", grids, LATCHED)
            [grid] = await asyncio.to_thread(grids.wait)
            assert (grid["info"]["width"], grid["info"]["height"]) == (office_map.info.width, office_map.info.height)

            planned = await both.act("compute_path_to_pose", PLAN, {"goal": stamped(goal)})
            path = await both.result("compute_path_to_pose", PLAN, planned)
            assert path["status"] == REACHED
            end = path["result"]["path"]["poses"][-1]["pose"]["position"]
            assert (end["x"], end["y"]) == pytest.approx((goal.x, goal.y), abs=0.1)

            driven = await both.act("navigate_to_pose", NAVIGATE, {"pose": stamped(goal)})
            result = await both.result("navigate_to_pose", NAVIGATE, driven)
            assert (result["status"], result["result"]["error_code"]) == (REACHED, 0)
            assert Scorer(both.world).error(0, goal) < 0.3
            heard = await asyncio.to_thread(feedback.wait)
            assert {one["goal_id"]["uuid"] for one in heard} == {driven}
            assert heard[-1]["feedback"]["navigation_time"]["sec"] >= 1
            assert plans.messages
            assert both.robot.commands[-1]["header"]["frame_id"] == "base_link"
            odoms = [
                one for message in frames.messages for one in message["transforms"] if one["child_frame_id"] == "odom"
            ]
            assert {one["header"]["frame_id"] for one in odoms} == {"map"}

            back = await both.act("navigate_to_pose", NAVIGATE, {"pose": stamped(start)})
            request = {"goal_info": {"goal_id": {"uuid": back}}}
            cancelled = await asyncio.to_thread(
                both.operator.call, "navigate_to_pose/_action/cancel_goal", "action_msgs/srv/CancelGoal", request
            )
            assert [one["goal_id"]["uuid"] for one in cancelled["goals_canceling"]] == [back]
            assert (await both.result("navigate_to_pose", NAVIGATE, back))["status"] == CANCELLED


async def reported(rest: RestClient, robot: str, wanted: Callable[[list[str]], bool]) -> None:
    """Wait until the doctor repeats the wanted reports of a robot's bridge."""
    async with patience(40.0):
        while True:
            found = await rest.get(f"/v1/robots/{robot}/diagnosis?seconds=0")
            if wanted([one["text"] for one in found["findings"] if one["kind"] == "robot-reports"]):
                return
            await asyncio.sleep(0.2)


async def test_a_robot_of_another_domain_is_told_to_the_doctor(
    cloud: RunningCloud, office_map: GridMap, tmp_path: Path
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    token = await register_robot(rest, "apart", "office", free_pose(office_map, seed=31))
    endpoint = free_endpoint()
    options = ("--transport", "zenoh", "--listen", endpoint, "--url", cloud.url, "--token", token)
    with bridge_process("apart", *options, log=tmp_path / "log"):
        apart = Peer(endpoint, "turtlebot", domain=7)
        apart.publisher("odom", "nav_msgs/msg/Odometry")
        here = None
        try:
            elsewhere = "robots are in domain 7, and the bridge in 0"
            await reported(rest, "apart", lambda texts: any(elsewhere in text for text in texts))
            here = Peer(endpoint, "turtlebot", release="kilted")
            here.publisher("odom", "nav_msgs/msg/Odometry")
            here.subscribe("cmd_vel", "geometry_msgs/msg/Twist", lambda _: None)
            await reported(
                rest,
                "apart",
                lambda texts: len(texts) == 1 and "'scan': the clone cannot localize it" in texts[0],
            )
        finally:
            apart.close()
            if here is not None:
                here.close()


@pytest.mark.ros
async def test_a_robot_on_pyzeros_is_driven(cloud: RunningCloud, office_map: GridMap, tmp_path: Path) -> None:
    """Keys, tokens and bytes of pyzeros are written by others, as those of rmw_zenoh."""
    if not CODECS.exists():
        pytest.skip("pyzeros is not installed: run make test-ros")
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=31)
    goal = reachable_pose(office_map, start, seed=32, at_least=1.5, at_most=3.0)
    token = await register_robot(rest, "pyzeros", "office", start)
    np.savez(tmp_path / "grid.npz", grid=office_map.data)
    endpoint = free_endpoint()
    options = ("--transport", "zenoh", "--listen", endpoint, "--url", cloud.url, "--token", token)
    with bridge_process("pyzeros", *options, log=tmp_path / "log"):
        numbers = [str(number) for number in (*start, goal.x, goal.y)]
        script = ROOT / "tests" / "support" / "ros2" / "pyzeros_robot.py"
        robot = await asyncio.create_subprocess_exec(
            PYZEROS,
            script,
            endpoint,
            tmp_path / "grid.npz",
            *numbers,
            stdout=asyncio.subprocess.PIPE,
            env=os.environ | {"CYDR_CACHE_DIR": str(CODECS)},
        )
        printed, _ = await asyncio.wait_for(robot.communicate(), 250)
    arrived = json.loads(printed)
    assert math.dist(arrived["pose"][:2], (goal.x, goal.y)) < 0.3
    assert arrived["cmd_vel"]
    assert "velocities go to /tb3/cmd_vel (Twist)" in (tmp_path / "log").read_text()
