"""A Nav2 viewer displays a robot that drives: its model, costmaps, footprint, local plan and commands.

Its WebSocket takes only small frames, so that it asks for fragments.
"""

import json
from collections.abc import AsyncIterator
from typing import Any

import numpy as np
import pytest
from websockets.asyncio.client import ClientConnection, connect

from ppaas.maps.grid import GridMap
from ppaas.wire.fragments import FragmentAssembler
from ppaas.wire.operations import Fragment
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.waiting import patience
from tests.support.world.places import free_pose, reachable_pose
from tests.support.world.urdf import example

pytestmark = pytest.mark.journey

TOPICS = {
    "/robot_description": "std_msgs/msg/String",
    "/global_costmap/costmap": "nav_msgs/msg/OccupancyGrid",
    "/local_costmap/costmap": "nav_msgs/msg/OccupancyGrid",
    "/move_base/local_costmap/costmap": "nav_msgs/OccupancyGrid",
    "/local_costmap/published_footprint": "geometry_msgs/msg/PolygonStamped",
    "/local_plan": "nav_msgs/msg/Path",
    "/cmd_vel": "geometry_msgs/msg/TwistStamped",
}


MAX_SIZE = 16384
"""Largest frame that the viewer takes [bytes]."""

OPTIONS = {"compression": "png", "fragment_size": MAX_SIZE // 2}


async def frames_of(socket: ClientConnection) -> AsyncIterator[dict[str, Any]]:
    """Yield the frames that come, those in fragments put together."""
    assembler = FragmentAssembler()
    async for text in socket:
        frame = json.loads(text)
        if frame["op"] != "fragment":
            yield frame
        elif (whole := assembler.add(Fragment(frame["data"], frame["num"], frame["total"], frame["id"]))) is not None:
            yield json.loads(whole)


async def first_of_each(frames: AsyncIterator[dict[str, Any]], topics: set[str]) -> dict[str, Any]:
    """Return the first message of each topic."""
    heard: dict[str, Any] = {}
    async with patience(30):
        async for frame in frames:
            assert frame["op"] == "publish", frame
            heard.setdefault(frame["topic"], frame["msg"])
            if heard.keys() >= topics:
                break
    return heard


def cells_of(grid: dict[str, Any]) -> "np.ndarray[Any, Any]":
    return np.array(grid["data"]).reshape(grid["info"]["height"], grid["info"]["width"])


async def test_a_viewer_gets_the_model_costmaps_and_commands_of_a_driving_robot(
    cloud: RunningCloud, office_map: GridMap
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=41)
    goal = reachable_pose(office_map, start, seed=42, at_least=2.0, at_most=4.0)
    token = await register_robot(rest, "shown", "office", start)
    urdf = example("turtlebot3_waffle")
    await rest.put_urdf("shown", urdf)
    url = f"{cloud.ws_url}/?robot=shown&role=operator&status=1&token={token}"
    async with (
        driving(cloud.url, token, "shown", office_map, start) as drive,
        connect(url, max_size=MAX_SIZE) as viewer,
    ):
        frames = frames_of(viewer)
        for topic, kind in TOPICS.items():
            await viewer.send(json.dumps({"op": "subscribe", "topic": topic, "type": kind, **OPTIONS}))
        await drive.send(goal)
        heard = await first_of_each(frames, set(TOPICS))
        call = {"op": "call_service", "service": "/rosapi/get_param", "id": "u", **OPTIONS}
        await viewer.send(json.dumps(call | {"args": {"name": "/robot_state_publisher:robot_description"}}))
        async with patience(10):
            while (answer := await anext(frames)).get("id") != "u":
                pass
    assert heard["/robot_description"]["data"] == json.loads(answer["values"]["value"]) == urdf.decode()
    whole, window = heard["/global_costmap/costmap"], heard["/local_costmap/costmap"]
    assert cells_of(whole).shape == office_map.data.shape and set(whole["header"]["stamp"]) == {"sec", "nanosec"}
    assert cells_of(window).shape == (120, 120)
    for grid in (whole, window, heard["/move_base/local_costmap/costmap"]):
        assert grid["header"]["frame_id"] == "map" and {0, 99, 100} <= set(np.unique(cells_of(grid)))
    assert len(heard["/local_costmap/published_footprint"]["polygon"]["points"]) >= 4
    assert len(heard["/local_plan"]["poses"]) == 18
    assert heard["/cmd_vel"]["header"]["frame_id"] == "base_link" and heard["/cmd_vel"]["twist"]["linear"]["x"] >= 0.0
