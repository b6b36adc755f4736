"""An unmodified roslibpy is an operator of the cloud."""

import asyncio
import os
import sys

import pytest

from ppaas.maps.grid import GridMap
from ppaas.navigation.parameters import MoveBaseParameters
from tests.support.cloud.client_script import operate
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.sources import ROOT
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

SCRIPT = ROOT / "docs" / "examples" / "roslibpy_operator.py"
OPERATOR = ROOT / "tests" / "support" / "cloud" / "roslibpy_operator.py"


async def test_a_roslibpy_script_monitors_the_robot_and_sends_a_goal(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=10)
    goal = reachable_pose(office_map, start, seed=11, at_least=2.0, at_most=3.0)
    token = await register_robot(rest, "tb-roslib", "office", start)
    url = f"{cloud.ws_url}/?robot=tb-roslib&role=operator"
    async with driving(cloud.url, token, "tb-roslib", office_map, start) as drive:
        script = await asyncio.create_subprocess_exec(
            sys.executable, str(SCRIPT), url, str(goal.x), str(goal.y),
            stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.STDOUT, env=os.environ | {"PPAAS_TOKEN": token},
        )  # fmt: skip
        output, _ = await script.communicate()
        assert script.returncode == 0, output.decode()
        assert drive.scorer.error(0, goal) <= 0.25
    assert "['/cmd_vel', '/map', '/scan', '/tf']" in output.decode()


async def test_roslibpy_drives_a_robot_by_topics_actions_and_services(cloud: RunningCloud, office_map: GridMap) -> None:
    command = [sys.executable, str(OPERATOR)]
    found, errors = await operate(command, cloud, office_map, "tb-roslibpy", seed=31)
    assert b"Exception" not in errors, errors.decode()
    assert {"/cmd_vel", "/map", "/scan"} <= set(found["topics"])
    assert {"/move_base/make_plan", "/static_map"} <= set(found["services"])
    assert {"/move_base"} <= set(found["actions"])
    assert {"/move_base", "/amcl"} <= set(found["nodes"])
    assert found["mapType"] == "nav_msgs/OccupancyGrid"
    assert found["frequency"] == MoveBaseParameters().controller_frequency
    assert found["cells"] == [office_map.data.size, office_map.data.size]
    assert (found["ros1Stamp"], found["ros2Stamp"]) == (["secs", "nsecs"], ["sec", "nanosec"])
    assert (found["byTopic"], found["ros1Ends"], found["ros1Feedback"]) == (3, [3, 2], ["base_position"])
    assert found["ros2Feedback"] == [
        "current_pose", "navigation_time", "estimated_time_remaining", "number_of_recoveries", "distance_remaining",
        "position_tracking_error", "heading_tracking_error",
    ]  # fmt: skip
    assert found["ros2Cancelled"][0] == "CANCELED"
    assert found["ros2Refused"][0] == "UNKNOWN" and "moon" in found["ros2Refused"][1]
    assert found["poses"] > 10
    assert found["lamp"] == {"success": True, "message": "on"}
    assert found["broken"] == {"no": "service '/lamp': the client reported a failure"}
    assert found["gossip"] == ["hello", "hello"]
    assert found["frame"] == ["translation", "rotation"]
