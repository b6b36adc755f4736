"""A list of waypoints is followed although its container is killed."""

import asyncio

import pytest

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.nav2_msgs import FollowWaypointsActionFeedback, FollowWaypointsActionResult
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose
from tests.support.world.touring import waypoints

pytestmark = pytest.mark.journey


async def test_waypoints_are_followed_to_the_end_despite_a_killed_container(
    cloud: RunningCloud, office_map: GridMap
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=11)
    # Turns in place exercise the list like drives do, and are done sooner.
    first, last = (Pose2D(*start) @ Pose2D(0.0, 0.0, turn) for turn in (0.6, -1.5))
    token = await register_robot(rest, "postman", "office", start)
    reported: list[int] = []
    results: asyncio.Queue[FollowWaypointsActionResult] = asyncio.Queue()
    async with driving(cloud.url, token, "postman", office_map, start) as drive:
        await drive.operator.subscribe(
            "follow_waypoints/feedback",
            FollowWaypointsActionFeedback,
            lambda message: reported.append(message.feedback.current_waypoint),
        )
        await drive.operator.subscribe("follow_waypoints/result", FollowWaypointsActionResult, results.put_nowait)
        await drive.operator.publish("follow_waypoints/goal", waypoints([first, last], "round"))
        await until(lambda: 1 in reported)
        cloud.container().kill()
        async with patience(60):
            result = await results.get()
        assert (result.status.goal_id.id, result.status.status) == ("round", Status.SUCCEEDED), result.status.text
        assert abs(wrap_angle(drive.world.robots[0].base.pose.theta - last.theta)) <= 0.3
        assert drive.robot.connections == 1
        reported_after = reported[reported.index(1) :]
        assert set(reported_after) == {1}, "no waypoint is driven to twice"
        assert results.empty()
