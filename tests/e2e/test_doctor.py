"""The doctor finds what a robot does wrong, over real sockets: in REST, on the command line, and on ROS's topic."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection, connect

from ppaas.maps.grid import GridMap
from ppaas.messages import encode
from robots.cli.examination import Examination
from robots.client.rest import RestClient
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.world.diagnosed_robot import DiagnosedRobot
from tests.support.world.places import free_pose

pytestmark = pytest.mark.journey

FRAME = "hokuyo_link"


async def send(socket: ClientConnection, **frame: Any) -> None:
    await socket.send(json.dumps(frame))


@asynccontextmanager
async def robot_without_tf(url: str, token: str) -> AsyncIterator[ClientConnection]:
    """Connect a robot that sends odometry and scans, whose laser no transform connects, and hears no command."""
    maker = DiagnosedRobot()

    async def sending(socket: ClientConnection) -> None:
        while True:
            for topic, message in (("odom", maker.odometry()), ("scan", maker.scan(FRAME))):
                message.header.stamp.secs = 0  # means the time of arrival
                message.header.stamp.nsecs = 0
                await send(socket, op="publish", topic=topic, msg=json.loads(encode(message)))
            await asyncio.sleep(0.1)

    async with connect(f"{url}/?robot=tf-less&token={token}") as socket:
        task = asyncio.create_task(sending(socket))
        try:
            yield socket
        finally:
            task.cancel()


async def test_robot_without_tf_is_told_so_everywhere(cloud: RunningCloud, office_map: GridMap) -> None:
    rest: RestClient = await cloud.admin()
    await publish_map(rest, "ward", office_map)
    token = await register_robot(rest, "tf-less", "ward", free_pose(office_map, seed=3))
    absent = await rest.get("/v1/robots/tf-less/diagnosis")
    assert [finding["kind"] for finding in absent["findings"]] == ["robot-not-connected"]
    async with robot_without_tf(cloud.ws_url, token) as socket:
        found: dict[str, Any] = {}

        async def scans_come() -> bool:
            found.update(await rest.get("/v1/robots/tf-less/diagnosis?seconds=2"))
            return bool(found["topics"]) and found["topics"][0]["rate"] > 4.0

        while not await scans_come():
            pass
        kinds = [finding["kind"] for finding in found["findings"]]
        assert kinds[:2] == ["frames-laser-unknown", "cmd-vel-unheard"]
        assert f"'{FRAME}', has no transform to 'base_link'" in found["findings"][0]["text"]
        assert {topic["name"]: topic["refused"] > 0 for topic in found["topics"]}["scan"]
        assert "base_link" in {frame["name"] for frame in found["frames"]}
        lines = {line["name"]: line for line in (await Examination(cloud.url, token, 0.0).cloud())["robots"]}
        assert (lines["tf-less"]["connected"], lines["tf-less"]["level"]) == (True, "error")
        await send(socket, op="subscribe", topic="/diagnostics")
        statuses = (json.loads(await socket.recv()))["msg"]["status"]
        assert "ppaas: frames-laser-unknown" in {status["name"] for status in statuses}
