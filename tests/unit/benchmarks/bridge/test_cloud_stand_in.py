"""The stand-in for a cloud takes the messages of a bridge's link."""

import json

from benchmarks.bridge.measurement import GOAL, ROBOT, TOPICS, cloud_stand_in
from robots.bridges.core.cloud_link import CloudLink
from robots.client.rest import RestClient
from tests.support.waiting import until


async def test_messages_are_noted_and_topics_are_those_of_a_clone() -> None:
    heard: list[bytes] = []
    async with cloud_stand_in() as cloud, CloudLink(cloud.url, robot="robot", token="t") as link:
        answer = json.loads(await link.call("rosapi/topics", "rosapi_msgs/srv/Topics", b"{}"))
        assert answer["topics"] == TOPICS
        await link.publish("scan", b"{}")
        await until(lambda: len(cloud.arrived["scan"]) == 1)
        await link.subscribe("cmd_vel", "geometry_msgs/msg/Twist", heard.append)
        await cloud.publish("cmd_vel", {"linear": {"x": 0.5}})
        await until(lambda: heard)
        assert json.loads(heard[0]) == {"linear": {"x": 0.5}}


async def test_each_connection_of_a_fleet_gets_what_is_published() -> None:
    heard: list[bytes] = []
    async with (
        cloud_stand_in() as cloud,
        CloudLink(cloud.url, robot="one", token="t") as one,
        CloudLink(cloud.url, robot="other", token="t") as other,
    ):
        for link in (one, other):
            await link.subscribe("amcl_pose", "geometry_msgs/PoseWithCovarianceStamped", heard.append)
        await cloud.publish("amcl_pose", {"pose": {}})
        await until(lambda: len(heard) == 2)


async def test_robots_and_goals_are_records_of_rest() -> None:
    async with cloud_stand_in() as cloud:
        rest = RestClient(cloud.url, "t")
        assert await rest.get("/v1/robots/robot") == ROBOT
        assert await rest.get("/v1/robots/robot/goals/goal") == GOAL
