"""The demo of a building in a running cloud: a robot takes a lift to a goal on another floor, without a contact."""

import pytest

from robots.demo.building import send_between_floors
from robots.demo.options import CloudAccess, DemoOptions
from tests.support.cloud.cloud import ADMIN_PASSWORD, RunningCloud

pytestmark = pytest.mark.journey


async def test_a_robot_of_the_demo_rides_to_its_goal(cloud: RunningCloud) -> None:
    lines: list[str] = []
    report = await send_between_floors(
        DemoOptions(robots=1, goals=1, seed=1, write=lines.append),
        CloudAccess(cloud.url, "admin", ADMIN_PASSWORD),
    )
    assert report.passed, report
    assert (report.map, report.rides) == ("house", 1)
    assert 0.0 < report.lift_wait_mean_s == report.lift_wait_max_s < report.seconds
    assert report.ride_mean_s > 5.0
    assert "turtlebot-1 is sent from L1 to " in "\n".join(lines)
