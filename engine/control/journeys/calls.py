"""Calls of endpoints about journeys over floors, which the process of the master leads."""

from collections.abc import Sequence
from typing import Protocol

from engine.control.journeys.views import LiftWait, SiteView
from engine.control.planning.building_requests import BuildingSpot
from engine.control.views import GoalView
from ppaas.buildings.journeys.records import Journey
from ppaas.geometry import Pose2D
from ppaas.tasks.records import GOALS

JOURNEY = "journey-"
"""Beginning of the ids of goals on floors that users send."""

ON_FLOORS = (JOURNEY, GOALS)
"""Beginnings of the ids of goals on floors, also of tasks."""


class JourneyCalls(Protocol):
    """Goals on floors of buildings."""

    async def send_to_floor(self, user: str, robot: str, floor: str, pose: Pose2D) -> GoalView:
        """Send a connected robot to a pose on a floor of the building whose floor its map is.

        Raises
        ------
        InvalidInput
            Its map is no floor of a building that its user may see, or the building has no such floor.
        Conflict
            It is on a journey, in a lift: cancel that first.
        Unavailable
            It is not connected.
        """
        ...

    async def journeys(self, user: str, robot: str) -> list[GoalView]:
        """Return the goals on floors that a robot was sent to, oldest first."""
        ...

    async def cancel_journey(self, user: str, robot: str, goal_id: str) -> GoalView:
        """Cancel a goal on a floor; a robot in a lift leaves it first.

        Raises
        ------
        NotFound
            It is unknown or forgotten.
        Conflict
            It has ended.
        """
        ...

    async def building_state(self, owner: str, building: str) -> SiteView:
        """Return the state of the lifts and doors of a building, and its journeys; its devices are connected for it.

        Raises
        ------
        NotFound
            There is no such building.
        """
        ...

    async def lift_waits(self, owner: str, building: str) -> list[LiftWait]:
        """Return the waits for the lifts of a building that are expected now; none where no robot travels."""
        ...


class TaskJourneys(Protocol):
    """Journeys that lead robots of tasks over floors, in the process of the master."""

    def of_robot(self, user: str, robot: str) -> list[Journey]:
        """Return the journeys of a robot that are remembered, oldest first."""
        ...

    async def lead(self, user: str, robot: str, floor: str, pose: Pose2D, *, goal_id: str = "") -> Journey:
        """Send a robot to a pose on a floor, as ``JourneyCalls.send_to_floor``; a goal of a given id is sent once."""
        ...

    async def cancel_journey(self, user: str, robot: str, goal_id: str) -> GoalView:
        """Cancel a goal on a floor, as ``JourneyCalls.cancel_journey``."""
        ...

    async def times(
        self, user: str, map_id: str, starts: Sequence[BuildingSpot], goals: Sequence[BuildingSpot]
    ) -> list[list[float | None]]:
        """Return the times from each start to each goal in the building of a map [s]; None where there is no way now.

        Raises
        ------
        InvalidInput
            The map is no floor of a building.
        PlanningError, QuotaExceeded, Queued, Starting, Unavailable
            As ``Planning.compute_path`` raises them.
        """
        ...
