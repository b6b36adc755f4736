"""The stand-in for a cloud takes the messages of a bridge's link."""

import json

from benchmarks.bridge.measurement import TOPICS, cloud_stand_in
from robots.bridges.core.cloud_link import CloudLink
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
