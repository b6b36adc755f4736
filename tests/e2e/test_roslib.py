"""An unmodified roslib in Node is an operator of the cloud: introspection, driving, services."""

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest

from ppaas.maps.grid import GridMap
from ppaas.navigation.parameters import MoveBaseParameters
from robots.client.rest import RestClient
from tests.support.cloud.client_script import operate
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.world.places import free_pose

pytestmark = pytest.mark.journey

FOLDER = Path(__file__).parent / "roslib"
CANCELED = "GoalError: Action was canceled"


async def test_roslib_drives_a_robot_by_topics_actions_and_services(
    node: str, cloud: RunningCloud, office_map: GridMap
) -> None:
    command = [node, str(FOLDER / "operator.mjs")]
    found, errors = await operate(command, cloud, office_map, "tb-roslibjs", seed=21)
    assert errors == b"", errors.decode()
    check_introspection(found, office_map)
    check_driving(found)
    assert found["poses"] > 10
    assert found["lights"] == {"success": True, "message": "on"}
    assert found["doors"] == {"reason": "Error: stuck"}
    assert found["chatter"] == ["hello", "hello"]


def check_introspection(found: dict[str, Any], grid: GridMap) -> None:
    assert {"/cmd_vel", "/map", "/scan"} <= set(found["topics"])  # type: ignore[call-overload]
    assert found["mapType"] == "nav_msgs/OccupancyGrid"
    assert {"/move_base/make_plan", "/static_map"} <= set(found["services"])  # type: ignore[call-overload]
    assert {"/move_base", "/navigate_to_pose"} <= set(found["actions"])  # type: ignore[call-overload]
    assert found["packed"] == ["Int8Array", True, True]
    assert found["raw"] == [True, True], "of ROS 1 and of ROS 2"
    assert found["frequency"] == MoveBaseParameters().controller_frequency
    assert found["cells"] == [grid.data.size, grid.data.size]
    assert (found["ros1Stamp"], found["ros2Stamp"]) == (["secs", "nsecs"], ["sec", "nanosec"])


def check_driving(found: dict[str, Any]) -> None:
    assert found["byTopic"] == 3
    assert found["byAction"] == {"result": {}}
    assert int(str(found["actionFeedback"])) > 5
    failure = found["cancelled"]["failed"]
    assert failure.startswith(CANCELED), failure
    assert found["navigateFeedback"] == [
        [
            "current_pose", "navigation_time", "estimated_time_remaining", "number_of_recoveries", "distance_remaining",
            "position_tracking_error", "heading_tracking_error",
        ],
        ["sec", "nanosec"],
    ]  # fmt: skip
    assert "moon" in found["refused"]["failed"]
    assert (found["ros1Feedback"], found["ros1Cancelled"]) == (["base_position"], 2)
    frames = found["frames"]
    assert len(frames) == 2 and all(abs(a - b) < 0.5 for a, b in zip(*frames, strict=True))


PASSWORD = "correct horse"


async def test_a_robot_offers_an_action_to_its_operator(node: str, cloud: RunningCloud, office_map: GridMap) -> None:
    admin = await cloud.admin()
    await publish_map(admin, "office", office_map)
    await admin.post("/v1/users", {"id": "docker", "password": PASSWORD})
    await admin.patch("/v1/maps/office", {"readers": ["docker"]})
    rest = RestClient(cloud.url)
    await rest.login("docker", PASSWORD)
    token = await register_robot(rest, "tb3-7", "office", free_pose(office_map, seed=61))
    url = f"{cloud.ws_url.replace('://', f'://docker:{token}@')}/?status=1"
    script = await asyncio.create_subprocess_exec(
        node, str(FOLDER / "docking.mjs"), url, "tb3_7",
        stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE,
    )  # fmt: skip
    output, errors = await script.communicate()
    assert (script.returncode, errors) == (0, b""), errors.decode()
    found = json.loads(output)
    assert found["goals"] == [{"dock_id": "home"}, {"dock_id": "away"}, {"dock_id": "gone"}]
    assert found["ends"]["home"] == {"result": {"success": True}, "heard": [{"state": 1}]}
    assert found["ends"]["away"]["failed"].startswith("GoalError: Action was canceled")
    assert found["ends"]["gone"]["failed"]
    assert found["beats"][1] > found["beats"][0]
    assert found["actionType"] == "dock_msgs/action/Dock"
    # roslib sends no type with a call, so it gets types as in ROS 1.
    assert (found["topicType"], found["version"]) == ("geometry_msgs/Twist", 2)
