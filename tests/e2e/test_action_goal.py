"""A goal sent as an action of ROS 2, by frames alone, while the container that drives dies and others send rubbish."""

import asyncio
import itertools
import json

import pytest
from websockets.asyncio.client import ClientConnection, connect

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages import encode
from ppaas.messages.geometry_msgs import Pose
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.waiting import patience
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

SUCCEEDED = 4
RUBBISH = (
    '{"op": "publish"',
    "[]",
    '{"op": "no such"}',
    '{"op": "publish", "topic": "/cmd_vel", "msg": {"linear": []}}',
)


def goal_frame(goal: Pose2D) -> str:
    pose = {"header": {"frame_id": "map"}, "pose": json.loads(encode(Pose.of(goal)))}
    return json.dumps({
        "op": "send_action_goal", "id": "g1", "action": "/navigate_to_pose", "feedback": True,
        "action_type": "nav2_msgs/action/NavigateToPose", "args": {"pose": pose},
    })  # fmt: skip


async def frames_until(socket: ClientConnection, operation: str) -> list[dict]:
    heard: list[dict] = []
    async with patience(90):
        while not heard or heard[-1]["op"] != operation:
            heard.append(json.loads(await socket.recv()))
    return heard


async def send_rubbish(url: str) -> None:
    async with connect(url) as socket:
        for frame in itertools.cycle(RUBBISH):
            await socket.send(frame)
            await asyncio.sleep(0.005)


async def test_action_goal_ends_once_despite_a_killed_container_and_rubbish(
    cloud: RunningCloud, office_map: GridMap
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=21)
    goal = reachable_pose(office_map, start, seed=22, at_least=2.0, at_most=4.0)
    token = await register_robot(rest, "actor", "office", start)
    url = f"{cloud.ws_url}/?robot=actor&role=operator&token={token}"
    async with driving(cloud.url, token, "actor", office_map, start) as drive, connect(url) as operator:
        rubbish = asyncio.create_task(send_rubbish(url))
        await operator.send(goal_frame(goal))
        await frames_until(operator, "action_feedback")
        cloud.container().kill()
        *feedback, result = await frames_until(operator, "action_result")
        assert (result["id"], result["action"], result["status"], result["result"]) == (
            "g1", "/navigate_to_pose", SUCCEEDED, True,
        )  # fmt: skip
        assert {frame["op"] for frame in feedback} == {"action_feedback"}
        assert drive.scorer.error(0, goal) <= 0.3
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(1.5):  # longer than the status period of Move Base
                await operator.recv()
        assert not rubbish.done()
        assert drive.robot.connections == 1
        rubbish.cancel()
