"""A lift lets a robot out on another floor than it says: the scans show it, and the journey goes on from there."""

import pytest
from msgspec.structs import replace

from ppaas.buildings.lifts.simulated import SimulatedLift
from ppaas.buildings.lifts.states import EndSession, LiftRequest, LiftState
from tests.support.cloud.cloud import RunningCloud, register_robot
from tests.support.cloud.drive import driving
from tests.support.cloud.floors import GOAL, HIGHER, START, ended, put_building, simulated_building, simulating
from tests.support.waiting import until

pytestmark = pytest.mark.journey


MISTAKEN = {"L2": "L3", "L3": "L2"}


class LyingLift(SimulatedLift):
    """Lift that takes two floors for each other, in what it does and in what it reports, until it is repaired."""

    def __init__(self, lift: SimulatedLift) -> None:
        self.honest, self.is_repaired = lift, False

    def named(self, floor: str) -> str:
        return floor if self.is_repaired else MISTAKEN.get(floor, floor)

    def request(self, request: LiftRequest, now: float) -> None:
        self.honest.request(replace(request, floor=self.named(request.floor)), now)

    def end(self, end: EndSession, now: float) -> None:
        self.honest.end(end, now)

    def state(self, now: float) -> LiftState:
        state = self.honest.state(now)
        return replace(state, floor=self.named(state.floor))


async def test_a_robot_arrives_although_the_lift_lets_it_out_on_a_wrong_floor(cloud: RunningCloud) -> None:
    rest, building = await cloud.admin(), simulated_building(building=HIGHER)
    lift = building.lifts["north"] = LyingLift(building.lifts["north"])
    async with simulating(building) as record:
        await put_building(rest, record)
        token = await register_robot(rest, "porter", "floor-1", tuple(START))
        async with driving(cloud.url, token, "porter", None, START, shared=building) as drive:
            await until(lambda: bool(drive.poses))
            goal = await rest.post("/v1/robots/porter/goals", {"pose": list(GOAL), "floor": "L2"})
            [porter] = building.robots
            await until(lambda: building.floor_of(porter) == "L3" and porter.base.pose.y < 2.2, 60.0)  # it is out
            lift.is_repaired = True
            last = await ended(rest, "porter", goal["id"])
            assert last["state"] == "succeeded", last
            assert building.floor_of(porter) == "L2" and porter.base.pose.distance_to(GOAL) < 0.35
            assert (await rest.get("/v1/robots/porter"))["map"] == "floor-2"
            assert drive.scorer.collisions(0) == 0 and drive.robot.connections == 1
