"""A client of Nav2 drives a robot by frames alone, while the container that drives dies."""

import json
import math
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection, connect

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridMap
from ppaas.messages import encode
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.geometry_msgs import Pose
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import Drive, driving
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

SUCCEEDED = 4
ALLOWANCE = {"sec": 30, "nanosec": 0}


def stamped(pose: Pose2D) -> dict[str, Any]:
    return {"header": {"frame_id": "map"}, "pose": json.loads(encode(Pose.of(pose)))}


class Navigator:
    """A client with the actions of Nav2's BasicNavigator."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket
        self.feedback: list[dict[str, Any]] = []

    async def send(self, action: str, kind: str, **args: Any) -> None:
        self.feedback.clear()
        await self._socket.send(json.dumps({
            "op": "send_action_goal", "id": action, "action": f"/{action}", "feedback": True,
            "action_type": f"nav2_msgs/action/{kind}", "args": args,
        }))  # fmt: skip

    async def publish(self, topic: str, pose: Pose2D) -> None:
        await self._socket.send(json.dumps({"op": "publish", "topic": topic, "msg": stamped(pose)}))

    async def hear(self) -> dict[str, Any]:
        """Return the next frame, and note feedback."""
        frame: dict[str, Any] = json.loads(await self._socket.recv())
        if frame["op"] == "action_feedback":
            self.feedback.append(frame["values"])
        return frame

    async def result(self) -> dict[str, Any]:
        """Return the values of a result, which must be that of a success."""
        async with patience(120):
            while (frame := await self.hear())["op"] != "action_result":
                pass
        assert (frame["status"], frame["result"]) == (SUCCEEDED, True), frame
        values: dict[str, Any] = frame["values"]
        return values

    async def do(self, action: str, kind: str, **args: Any) -> dict[str, Any]:
        await self.send(action, kind, **args)
        return await self.result()


async def standing(drive: Drive) -> Pose2D:
    """Return where the robot stands: on a busy computer it moves on for a while after a result."""
    base = drive.world.robots[0].base
    await until(lambda: abs(base.wheels.linear) < 1e-3 and abs(base.wheels.angular) < 1e-3)
    return base.pose


async def test_a_client_of_nav2_plans_drives_turns_and_backs_up(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=21)
    between = reachable_pose(office_map, start, seed=22, at_least=1.5, at_most=2.5)
    last = reachable_pose(office_map, between, seed=23, at_least=1.5, at_most=2.5)
    token = await register_robot(rest, "nav2", "office", start)
    url = f"{cloud.ws_url}/?robot=nav2&role=operator&token={token}"
    async with driving(cloud.url, token, "nav2", office_map, start) as drive, connect(url) as socket:
        navigator = Navigator(socket)
        poses = [stamped(between), stamped(last)]
        planned = await navigator.do("compute_path_through_poses", "ComputePathThroughPoses", goals=poses)
        points = [each["pose"]["position"] for each in planned["path"]["poses"]]
        assert any(math.dist((at["x"], at["y"]), between[:2]) < 0.01 for at in points)

        await navigator.send("navigate_through_poses", "NavigateThroughPoses", poses=poses)
        while not navigator.feedback:
            await navigator.hear()
        cloud.container().kill()
        await navigator.result()
        remaining = [each["number_of_poses_remaining"] for each in navigator.feedback]
        assert (set(remaining), remaining) == ({1, 2}, sorted(remaining, reverse=True))
        assert max(each["estimated_time_remaining"]["sec"] for each in navigator.feedback) >= 2
        assert drive.scorer.error(0, last) <= 0.3

        before = await standing(drive)
        await navigator.do("spin", "Spin", target_yaw=-1.57, time_allowance=ALLOWANCE)
        turned = await standing(drive)
        assert abs(wrap_angle(turned.theta - before.theta + 1.57)) < 0.3
        await navigator.do("backup", "BackUp", target={"x": 0.1}, speed=0.1, time_allowance=ALLOWANCE)
        backed = (turned.inverse() @ await standing(drive)).x
        assert -0.2 < backed < -0.05

        assert drive.results.empty()
        await navigator.publish("/goal_pose", between)
        assert (await drive.result()).status.status == Status.SUCCEEDED
        assert drive.scorer.error(0, between) <= 0.3
        assert drive.robot.connections == 1
