"""A lift lets a robot out on another floor than it says: the scans show it, and the journey goes on from there."""

import pytest

from ppaas.geometry import Pose2D
from tests.support.cloud.cloud import RunningCloud, register_robot
from tests.support.cloud.drive import driving
from tests.support.cloud.floors import (
    ATTIC,
    BETWEEN,
    GOAL,
    GROUND,
    HIGHER,
    LOFT,
    START,
    carried,
    ended,
    put_building,
    world_of,
)
from tests.support.waiting import until

pytestmark = pytest.mark.journey


async def test_a_robot_arrives_although_the_lift_lets_it_out_on_a_wrong_floor(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    await put_building(rest, HIGHER)
    token = await register_robot(rest, "porter", "floor-1", tuple(START))
    async with driving(cloud.url, token, "porter", world_of(GROUND, LOFT, ATTIC), START) as drive:
        await until(lambda: bool(drive.poses))
        async with carried([rest], drive, "porter", lies=["floor-3"]) as maps:
            goal = await rest.post("/v1/robots/porter/goals", {"pose": list(GOAL), "floor": "L2"})
            last = await ended(rest, "porter", goal)
        assert last["state"] == "succeeded", last
        assert maps == ["floor-1", "floor-2", "floor-3", "floor-2"], "it was on L3, and took the lift once more"
        assert drive.world.robots[0].base.pose.distance_to(Pose2D(GOAL.x + BETWEEN, GOAL.y)) < 0.35
        assert drive.scorer.collisions(0) == 0 and drive.robot.connections == 1
