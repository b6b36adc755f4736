"""Journeys over floors for tests of REST, without a master."""

import msgspec

from engine.control.buildings.views import BuildingView
from engine.control.journeys.views import LiftWait, SiteView
from engine.control.views import GoalView
from ppaas.errors import InvalidBuilding, NotFound
from ppaas.geometry import Pose2D


class FakeJourneys:
    """Leads one journey, or refuses; the state of its building is what a test says."""

    def __init__(self) -> None:
        self.sent: list[GoalView] = []
        self.asked: list[tuple[str, str, str]] = []
        self.state = SiteView(BuildingView([], [], []), [])
        self.waits: list[LiftWait] = []

    async def send_to_floor(self, user: str, robot: str, floor: str, pose: Pose2D) -> GoalView:
        if floor != "L2":
            raise InvalidBuilding(f"there is no floor {floor!r}")
        self.asked.append((user, robot, floor))
        self.sent.append(GoalView("journey-1", (pose.x, pose.y, pose.theta), "active", "", 50.0))
        return self.sent[-1]

    async def journeys(self, user: str, robot: str) -> list[GoalView]:
        return self.sent

    async def cancel_journey(self, user: str, robot: str, goal_id: str) -> GoalView:
        if goal_id not in {goal.id for goal in self.sent}:
            raise NotFound("goal", goal_id)
        self.sent = [msgspec.structs.replace(self.sent[0], state="canceled", ended=60.0)]
        return self.sent[0]

    async def building_state(self, owner: str, building: str) -> SiteView:
        return self.state

    async def lift_waits(self, owner: str, building: str) -> list[LiftWait]:
        return self.waits
