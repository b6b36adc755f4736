"""From login to goal: the cloud drives a simulated Turtlebot."""

import asyncio
import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav_msgs import GetPlan, GetPlanRequest, GetPlanResponse, Path
from robots.client.rest import RestClient
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import Drive, driving
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey


@asynccontextmanager
async def driving_in_office(
    cloud: RunningCloud, office_map: GridMap, robot: str, start: Pose2D
) -> AsyncIterator[tuple[RestClient, Drive]]:
    """Publish the office map, register a robot on it, and connect the robot."""
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    token = await register_robot(rest, robot, "office", start)
    async with driving(cloud.url, token, robot, office_map, start) as drive:
        yield rest, drive


async def test_a_turtlebot_drives_to_its_goal_without_a_collision(cloud: RunningCloud, office_map: GridMap) -> None:
    start = free_pose(office_map, seed=1)
    goal = reachable_pose(office_map, start, seed=2, at_least=4.0)
    async with driving_in_office(cloud, office_map, "tb1", start) as (_, drive):
        assert await drive.go(goal) <= 0.25
        assert drive.scorer.collisions(0) == 0
        await until(lambda: drive.commands[-1][1].linear.x == 0.0)


async def test_a_plan_can_be_requested_without_moving(cloud: RunningCloud, office_map: GridMap) -> None:
    start = free_pose(office_map, seed=6)
    goal = reachable_pose(office_map, start, seed=7, at_least=4.0)
    async with driving_in_office(cloud, office_map, "thinker", start) as (_, drive):
        header = Header(frame_id="map")
        request = GetPlanRequest(PoseStamped(header, Pose.of(start)), PoseStamped(header, Pose.of(goal)))
        response = await drive.operator.call("move_base/make_plan", GetPlan, request)
        assert isinstance(response, GetPlanResponse)
        last = response.plan.poses[-1].pose.position
        assert math.hypot(last.x - goal.x, last.y - goal.y) < 0.1
        assert drive.scorer.distance(0) < 0.01


async def test_plans_are_published_to_operators(cloud: RunningCloud, office_map: GridMap) -> None:
    start = free_pose(office_map, seed=8)
    plans: list[Path] = []
    async with driving_in_office(cloud, office_map, "planner", start) as (_, drive):
        await drive.operator.subscribe("plan", Path, plans.append)
        await drive.go(reachable_pose(office_map, start, seed=9, at_least=2.0))
    assert len(plans[0].poses) > 10


async def test_a_program_drives_a_robot_by_rest(cloud: RunningCloud, office_map: GridMap) -> None:
    start = free_pose(office_map, seed=10)
    goal = reachable_pose(office_map, start, seed=11, at_least=2.0)
    async with driving_in_office(cloud, office_map, "fleet1", start) as (rest, drive):
        sent = await rest.post("/v1/robots/fleet1/goals", {"pose": list(goal)})
        while sent["state"] in ("pending", "active"):
            await asyncio.sleep(0.2)
            sent = await rest.get(f"/v1/robots/fleet1/goals/{sent['id']}")
        assert sent["state"] == "succeeded", sent
        assert drive.scorer.error(0, goal) <= 0.25
        state = await rest.get("/v1/robots/fleet1/state")
        assert drive.world.robots[0].base.pose.distance_to(Pose2D(*state["pose"])) <= 0.25
