"""A robot of 2013 runs on this cloud: its client speaks the protocol of Rapyuta."""

import asyncio
import json
import zlib
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any, cast

import msgspec
import numpy as np
import pytest
from websockets.exceptions import InvalidStatus

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages import Message, encode
from ppaas.messages.geometry_msgs import Pose, Twist
from ppaas.wire.ros import ros_types
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from robots.demo.scorer import Scorer
from robots.sim.driver import Driver
from robots.sim.simulator import Simulator
from robots.sim.world import World
from tests.support.clients.rce import RceRobot, rce_robot
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

USER, OWN_PASSWORD, PASSWORD = "ann2013", "correct horse", "the robots of 2013"

INTERFACES = {
    "scan": ("Subscriber", "sensor_msgs/LaserScan", "/tb2013/base_scan"),
    "odom": ("Subscriber", "nav_msgs/Odometry", "/odom"),
    "goal": ("Subscriber", "geometry_msgs/PoseStamped", "/move_base_simple/goal"),
    "cmd_vel": ("Publisher", "geometry_msgs/Twist", "/cmd_vel"),
    "pose": ("Publisher", "geometry_msgs/PoseWithCovarianceStamped", "/amcl_pose"),
    "status": ("Publisher", "actionlib_msgs/GoalStatusArray", "/move_base/status"),
    "map": ("Publisher", "nav_msgs/OccupancyGrid", "/map"),
    "plan": ("ServiceProvider", "nav_msgs/GetPlan", "/move_base/make_plan"),
}
"""Interfaces of the robot: role, class, and the name in the container."""

FORWARDED = {"pose"}
"""Interfaces whose messages are in the serialization of ROS 1."""

OTHER = {"Subscriber": "Publisher", "Publisher": "Subscriber", "ServiceProvider": "ServiceClient"}


def _in_2013(message: Message) -> Any:
    """Return a message as a converter of 2013 has it: the stamp as text."""
    fields = json.loads(encode(message))
    stamp = fields["header"]["stamp"]
    moment = datetime.fromtimestamp(stamp["secs"] + stamp["nsecs"] * 1e-9, UTC)
    fields["header"]["stamp"] = moment.strftime("%Y-%m-%dT%H:%M:%S.%f")
    return fields


class SensorsOf2013:
    """What the simulator's driver needs of a client, by a robot of 2013: odometry as JSON, ranges as binary parts."""

    def __init__(self, robot: RceRobot) -> None:
        self._rce = robot
        self.commands = 0

    async def publish(self, topic: str, message: Message, **_: Any) -> None:
        fields = _in_2013(message)
        if topic == "scan":
            ranges = [np.nan if value is None else value for value in fields["ranges"]]
            fields["ranges"] = np.array(ranges, "<f4").tobytes()
        await self._rce.send(topic, INTERFACES[topic][1], fields)

    async def subscribe(self, topic: str, kind: type[Message], take: Callable[[Any], object], **_: Any) -> None:
        def received(cls: str, _message_id: str, message: Any) -> None:
            assert cls == INTERFACES[topic][1]
            self.commands += 1
            take(msgspec.convert(message, Twist))

        self._rce.on(topic, received)


async def _configure(robot: RceRobot) -> None:
    """Do what the file of a robot of 2013 describes: containers, nodes, parameters, interfaces, connections."""
    await robot.create_container("c1")
    await robot.add_node("c1", "maps", "map_server", "map_server", "office.yaml")
    await robot.add_node("c1", "amcl", "amcl", "amcl", "scan:=base_scan _max_particles:=1500", name="localization")
    await robot.add_node("c1", "driving", "move_base", "move_base")
    await robot.add_parameter("c1", "/localization/min_particles", 300)
    await robot.add_parameter("c1", "/battery/limit", 11.5)
    for tag, (role, cls, name) in INTERFACES.items():
        await robot.add_interface("c1", tag, f"{OTHER[role]}Interface", cls, name.replace("/tb2013", ""))
        form = "Forwarder" if tag in FORWARDED else "Converter"
        await robot.add_interface("tb2013", tag, f"{role}{form}", cls)
        await robot.add_connection(f"tb2013/{tag}", f"c1/{tag}")


async def test_a_robot_of_2013_drives_to_its_goal(cloud: RunningCloud, rapyuta_port: int, office_map: GridMap) -> None:
    master = f"http://127.0.0.1:{rapyuta_port}/"
    start = free_pose(office_map, seed=1)
    goal = reachable_pose(office_map, start, seed=2, at_least=2.0, at_most=3.0)
    admin, owner = await cloud.admin(), RestClient(cloud.url)
    await admin.post("/v1/users", {"id": USER, "password": OWN_PASSWORD})
    await owner.login(USER, OWN_PASSWORD)
    await publish_map(owner, "office2013", office_map)
    await register_robot(owner, "tb2013", "office2013", start)
    await _refused(master, PASSWORD)
    await admin.patch(f"/v1/users/{USER}", {"rapyuta_password": PASSWORD})
    await _refused(master, OWN_PASSWORD)
    async with rce_robot(master, USER, "tb2013", PASSWORD) as robot:
        await _configure(robot)
        await _drive(robot, World(office_map, 0), start, goal)
    found = await owner.get("/v1/robots/tb2013")
    assert found["parameters"] == {"amcl": {"max_particles": 1500, "min_particles": 300}}
    events = (await admin.get("/v1/audit?action=connect"))["items"]
    mine = [(event["status"], event.get("user")) for event in events if event["object"] == "robots/tb2013"]
    assert mine == [(101, USER), (401, None), (401, None)]


async def _refused(master: str, password: str) -> None:
    with pytest.raises(InvalidStatus) as refused:
        async with rce_robot(master, USER, "tb2013", password):
            pass
    assert refused.value.response.status_code == 401


async def _drive(robot: RceRobot, world: World, start: Pose2D, goal: Pose2D) -> None:
    simulated, scorer, client = world.add_robot(start), Scorer(world), SensorsOf2013(robot)
    received: dict[str, list[Any]] = {tag: [] for tag in INTERFACES}
    for tag in ("pose", "status", "map", "plan"):
        robot.on(tag, _collector(received[tag], forwarded=tag in FORWARDED))
    tasks = [
        asyncio.create_task(Simulator(world).run()),
        asyncio.create_task(Driver(simulated, cast(RobotClient, client)).run()),
    ]
    try:
        await until(lambda: bool(received["pose"]) or bool(robot.errors), 30)
        assert not robot.errors
        assert sorted(robot.statuses) == sorted((tag, True) for tag in INTERFACES)
        target = {"header": {"frame_id": "map"}, "pose": json.loads(encode(Pose.of(goal)))}
        asked = await robot.send("plan", "nav_msgs/GetPlan", {"start": _pose(received), "goal": target})
        await robot.send("goal", "geometry_msgs/PoseStamped", target)
        await until(lambda: bool(received["plan"]), 30)
        [(message_id, answer)] = received["plan"]
        assert message_id == asked and len(answer["plan"]["poses"]) > 2
        await until(lambda: _ended(received["status"]), 90)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
    assert scorer.error(0, goal) <= 0.25
    assert client.commands > 10
    [(_, grid)] = received["map"]
    assert len(grid["data"]) == grid["info"]["width"] * grid["info"]["height"]
    assert datetime.fromisoformat(received["status"][-1][1]["header"]["stamp"]).year > 2013


def _collector(found: list[Any], *, forwarded: bool) -> Callable[[str, str, Any], None]:
    """Return a receiver that collects the ids of messages, and the messages."""

    def received(cls: str, message_id: str, message: Any) -> None:
        if forwarded:
            message = ros_types("noetic").decode(cls, zlib.decompress(message))
        found.append((message_id, message))

    return received


def _pose(received: dict[str, list[Any]]) -> dict[str, Any]:
    """Return the estimate of the pose, as a pose with a header."""
    _, estimate = received["pose"][-1]
    return {"header": {"frame_id": estimate["header"]["frame_id"]}, "pose": estimate["pose"]["pose"]}


def _ended(statuses: list[Any]) -> bool:
    return any(status["status"] == 3 for _, message in statuses[-1:] for status in message["status_list"])
