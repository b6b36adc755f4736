"""An unmodified roslib in Node is a robot below a namespace that offers an action, and its operator.

They know an address alone: user and token are in it, and the user's only robot is not.
"""

import asyncio
import json
from pathlib import Path

import pytest

from ppaas.maps.grid import GridMap
from robots.client.rest import RestClient
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.world.places import free_pose

pytestmark = pytest.mark.journey

FOLDER = Path(__file__).parent / "roslib"
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
    assert found["actionType"] == "nav2_msgs/action/DockRobot"
    # roslib sends no type with a call, so it gets types as in ROS 1.
    assert (found["topicType"], found["version"]) == ("geometry_msgs/Twist", 2)
