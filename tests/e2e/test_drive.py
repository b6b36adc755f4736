"""From login to goal: the cloud drives a simulated Turtlebot."""

import asyncio
import math

import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav_msgs import GetPlan, GetPlanRequest, GetPlanResponse, Path
from ppaas.messages.std_msgs import Header
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey


async def test_a_turtlebot_drives_to_its_goal_without_a_collision(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=1)
    goal = reachable_pose(office_map, start, seed=2, at_least=4.0)
    token = await register_robot(rest, "tb1", "office", start)
    async with driving(cloud.url, token, "tb1", office_map, start) as drive:
        assert await drive.go(goal) <= 0.25
        assert drive.scorer.collisions(0) == 0
        await until(lambda: drive.commands[-1][1].linear.x == 0.0)


async def test_a_plan_can_be_requested_without_moving(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=6)
    goal = reachable_pose(office_map, start, seed=7, at_least=4.0)
    token = await register_robot(rest, "thinker", "office", start)
    async with driving(cloud.url, token, "thinker", office_map, start) as drive:
        header = Header(frame_id="map")
        request = GetPlanRequest(PoseStamped(header, Pose.of(start)), PoseStamped(header, Pose.of(goal)))
        response = await drive.operator.call("move_base/make_plan", GetPlan, request)
        assert isinstance(response, GetPlanResponse)
        last = response.plan.poses[-1].pose.position
        assert math.hypot(last.x - goal.x, last.y - goal.y) < 0.1
        assert drive.scorer.distance(0) < 0.01


async def test_plans_are_published_to_operators(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=8)
    token = await register_robot(rest, "planner", "office", start)
    plans: list[Path] = []
    async with driving(cloud.url, token, "planner", office_map, start) as drive:
        await drive.operator.subscribe("plan", Path, plans.append)
        await drive.go(reachable_pose(office_map, start, seed=9, at_least=2.0))
    assert len(plans[0].poses) > 10


async def test_a_program_drives_a_robot_by_rest(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=10)
    goal = reachable_pose(office_map, start, seed=11, at_least=2.0)
    token = await register_robot(rest, "fleet1", "office", start)
    async with driving(cloud.url, token, "fleet1", office_map, start) as drive:
        sent = await rest.post("/v1/robots/fleet1/goals", {"pose": list(goal)})
        while sent["state"] in ("pending", "active"):
            await asyncio.sleep(0.2)
            sent = await rest.get(f"/v1/robots/fleet1/goals/{sent['id']}")
        assert sent["state"] == "succeeded", sent
        assert drive.scorer.error(0, goal) <= 0.25
        state = await rest.get("/v1/robots/fleet1/state")
        assert drive.world.robots[0].base.pose.distance_to(Pose2D(*state["pose"])) <= 0.25
