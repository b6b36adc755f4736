"""Robots respect the keepout masks named in their files, and obstacles of their octomaps."""

import asyncio

import numpy as np
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from ppaas.errors import Conflict, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import save_map
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav_msgs import GetPlan, GetPlanRequest, GetPlanResponse
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.local_nodes import ABLE, managing, take_over
from tests.support.sources import ROOT
from tests.support.waiting import patience

pytestmark = pytest.mark.journey

ROOM = GridMap(np.zeros((60, 80), np.int8), GridInfo(0.05, 80, 60))
START, GOAL = Pose2D(0.5, 1.5), Pose2D(3.5, 1.5)


def mask(rows: slice) -> GridMap:
    """Return a mask of cells of 0.5 m that bars some rows of the middle of the room."""
    data = np.zeros((6, 8), np.int8)
    data[rows, 3:5] = 100
    return GridMap(data, GridInfo(0.5, 8, 6))


async def careful_robot(rest: RestClient, robot: str) -> str:
    """Register a robot whose mask bars the lower half of the middle of its own room; return its token."""
    await publish_map(rest, f"{robot}-room", ROOM)
    await publish_map(rest, f"{robot}-keepout", mask(slice(0, 4)))
    token = await register_robot(rest, robot, f"{robot}-room", tuple(START))
    await rest.patch(f"/v1/robots/{robot}", {"parameters": {"keepout_filter": {"filter_mask": f"{robot}-keepout"}}})
    return token


async def sides(cloud: RunningCloud, token: str, robot: str = "careful") -> set[bool]:
    """Plan across the room in the robot's clone; return on which sides of the straight line it passes the middle."""
    async with RobotClient(cloud.ws_url, robot=robot, token=token) as client:
        return await passed(client)


async def passed(client: RobotClient) -> set[bool]:
    """Plan with Move Base in either home; return on which sides the path passes."""
    there, back = (PoseStamped(Header(frame_id="map"), Pose.of(pose)) for pose in (START, GOAL))
    answer = await client.call("move_base/make_plan", GetPlan, GetPlanRequest(there, back), 30.0)
    assert isinstance(answer, GetPlanResponse)
    middle = [pose.pose.position.y for pose in answer.plan.poses if 1.5 < pose.pose.position.x < 2.5]
    return {y > 1.5 for y in middle if abs(y - 1.5) > 0.3}


async def test_robots_plan_with_the_masks_named_in_their_files(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "masked-room", ROOM)
    named = {"keepout_filter": {"filter_mask": "masked-room-keepout"}}
    token = await register_robot(rest, "careful", "masked-room", tuple(START))
    with pytest.raises(InvalidParameter, match="keepout_filter: the mask 'masked-room-keepout' is not a published map"):
        await rest.patch("/v1/robots/careful", {"parameters": named})
    await publish_map(rest, "masked-room-keepout", mask(slice(0, 4)))
    await rest.patch("/v1/robots/careful", {"parameters": named})
    assert await sides(cloud, token) == {True}
    with pytest.raises(Conflict, match="is in use by robots"):
        await rest.delete("/v1/maps/masked-room-keepout")
    await publish_map(rest, "masked-room-keepout", mask(slice(2, 6)))
    async with RobotClient(cloud.ws_url, robot="careful", token=token) as client, patience(20.0):
        while await passed(client) != {False}:  # its clone follows once its machine has made the layers
            await asyncio.sleep(0.1)
    await rest.patch("/v1/robots/careful", {"parameters": {"keepout_filter": {"enabled": False}}})
    assert await sides(cloud, token) == set()


async def test_a_robot_whose_mask_was_deleted_is_refused(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    token = await careful_robot(rest, "late")
    await rest.delete("/v1/maps/late-keepout")
    with pytest.raises(InvalidStatus) as refused:
        await connect(f"{cloud.ws_url}/?robot=late&token={token}")
    assert refused.value.response.status_code == 422
    assert b"keepout_filter: the mask 'late-keepout' is not a published map" in refused.value.response.body


async def test_a_local_node_respects_the_same_mask(cloud: RunningCloud) -> None:
    token = await careful_robot(await cloud.admin(), "own")
    async with RobotClient(cloud.ws_url, robot="own", token=token) as client, managing(client, ABLE) as manager:
        await take_over(manager, "move_base")
        assert await passed(client) == {True}


async def test_a_tall_robot_plans_around_a_table_above_its_laser(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    yaml, image = save_map(ROOM, "room.pgm")
    await rest.upload_map("room-with-table", yaml, image, octomap=ROOT / "docs" / "examples" / "table.bt")
    token = await register_robot(rest, "tall", "room-with-table", tuple(START))
    assert await sides(cloud, token, "tall") == set()
    await rest.patch("/v1/robots/tall", {"parameters": {"voxel_layer": {"max_obstacle_height": 1.2}}})
    assert len(await sides(cloud, token, "tall")) == 1
