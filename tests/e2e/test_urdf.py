"""A robot that was described by its URDF is planned and driven for as that says, from when it connects."""

import json

import pytest
from websockets.asyncio.client import connect

from ppaas.maps.grid import GridMap
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.world.places import free_pose
from tests.support.world.urdf import example

pytestmark = pytest.mark.journey


async def parameters_of(cloud: RunningCloud, robot: str, token: str) -> dict[str, dict[str, object]]:
    """Return what a robot's clone goes by, as an operator asks for it; the robot leaves nothing behind."""
    async with connect(f"{cloud.ws_url}/?robot={robot}&token={token}") as socket:
        await socket.send(json.dumps({"op": "call_service", "service": "/rosapi/get_param", "args": {"name": "/"}}))
        while (frame := json.loads(await socket.recv()))["op"] != "service_response":
            pass
    told: dict[str, dict[str, object]] = json.loads(frame["values"]["value"])
    return told


async def test_a_clone_has_the_body_that_its_urdf_tells(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    told = {}
    for robot in ("plain", "described"):
        token = await register_robot(rest, robot, "office", tuple(free_pose(office_map, seed=30)))
        if robot == "described":
            await rest.put_urdf(robot, example("turtlebot3_waffle"))
        told[robot] = await parameters_of(cloud, robot, token)
    assert [told[robot]["global_costmap"]["robot_radius"] for robot in told] == [0.18, 0.238]
    assert [told[robot]["dwa"]["max_vel_x"] for robot in told] == [0.65, pytest.approx(0.26, abs=1e-3)]
