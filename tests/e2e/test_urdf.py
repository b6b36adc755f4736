"""The clone of a robot with a URDF uses the body and limits of the URDF."""

import json

import pytest
from websockets.asyncio.client import connect

from ppaas.maps.grid import GridMap
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.world.places import free_pose
from tests.support.world.urdf import example

pytestmark = pytest.mark.journey


async def parameters_of(cloud: RunningCloud, robot: str, token: str) -> dict[str, dict[str, object]]:
    """Return the parameters of a robot's clone; its place is released afterwards."""
    async with connect(f"{cloud.ws_url}/?robot={robot}&token={token}") as socket:
        await socket.send(json.dumps({"op": "call_service", "service": "/rosapi/get_param", "args": {"name": "/"}}))
        while (frame := json.loads(await socket.recv()))["op"] != "service_response":
            pass
    parameters: dict[str, dict[str, object]] = json.loads(frame["values"]["value"])
    return parameters


async def test_a_clone_uses_the_body_and_limits_of_its_urdf(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    parameters = {}
    for robot in ("plain", "described"):
        token = await register_robot(rest, robot, "office", tuple(free_pose(office_map, seed=30)))
        if robot == "described":
            await rest.put_urdf(robot, example("turtlebot3_waffle"))
        parameters[robot] = await parameters_of(cloud, robot, token)
    assert [parameters[robot]["global_costmap"]["robot_radius"] for robot in parameters] == [0.18, 0.238]
    assert [parameters[robot]["dwa"]["max_vel_x"] for robot in parameters] == [0.65, pytest.approx(0.26, abs=1e-3)]
