"""Trips of robots with tasks to other floors: journeys that carry the ids of the tasks' goals."""

from engine.control.journeys.calls import TaskJourneys
from engine.control.journeys.leader import view_of
from engine.control.views import GoalView
from ppaas.buildings.journeys.records import Journey
from ppaas.errors import InvalidBuilding, InvalidInput
from ppaas.geometry import Pose2D
from ppaas.tasks.floors import floor_of
from ppaas.tasks.orders import Send
from ppaas.tasks.records import GOALS, pose_of

BEFORE_DOCK = 1.0
"""Distance from a dock of the place to which a robot is led on its floor [m]."""


class FloorTrips:
    """Sends the robots of a user over the floors of buildings.

    A robot that is in a lift or at a dock leaves that before it is sent elsewhere: the order waits until then. One that
    is sent to a dock of another floor comes to the place before it, and docks afterwards.

    Parameters
    ----------
    journeys : TaskJourneys
    user : str

    Attributes
    ----------
    waiting : dict of str to Send
        Orders to robots in lifts or at docks, by robot: the last one of each.
    docking : dict of str to Send
        Orders to robots that are on their way to the floor of a dock, or have come there.
    """

    def __init__(self, journeys: TaskJourneys, user: str) -> None:
        self._journeys, self._user = journeys, user
        self._refused: dict[str, GoalView] = {}
        self.waiting: dict[str, Send] = {}
        self.docking: dict[str, Send] = {}

    def goals(self, robot: str) -> list[GoalView]:
        """Return the goals on floors that a robot was sent to, also those that were refused."""
        refused = [self._refused[robot]] if robot in self._refused else []
        return [*map(view_of, self._journeys.of_robot(self._user, robot)), *refused]

    def led(self, robot: str) -> frozenset[str]:
        """Return the goals on floors to which a robot is led now, by tasks or by users."""
        return frozenset(journey.id for journey in self._active(robot))

    def is_riding(self, robot: str) -> bool:
        """Return whether a robot is in a lift."""
        return any(journey.is_aboard for journey in self._active(robot))

    def is_leaving(self, robot: str, goal_id: str) -> bool:
        """Return whether a robot is on its way for another goal than its task's, which it leaves in a lift first."""
        return any(journey.is_aboard and journey.id != goal_id for journey in self._active(robot))

    async def make_way(self, order: Send) -> bool:
        """Cancel the other journeys of tasks of a robot; return whether it may be sent now, or is in a lift still."""
        self.waiting.pop(order.robot, None)
        self.docking.pop(order.robot, None)
        for journey in self._active(order.robot):
            if journey.id.startswith(GOALS) and journey.id != order.goal_id:
                await self._journeys.cancel_journey(self._user, order.robot, journey.id)
        if self.is_leaving(order.robot, order.goal_id):
            self.waiting[order.robot] = order
            return False
        return True

    async def send(self, order: Send) -> None:
        """Send a robot to a floor; a goal for which there is no building or floor any more is refused."""
        pose = pose_of(order.place)
        if order.dock:
            self.docking[order.robot] = order
            pose @= Pose2D(-BEFORE_DOCK, 0.0)
        try:
            await self._journeys.lead(self._user, order.robot, floor_of(order.place), pose, goal_id=order.goal_id)
        except (InvalidInput, InvalidBuilding) as error:
            self._refused[order.robot] = GoalView(order.goal_id, order.place, "rejected", str(error), 0.0, 0.0)

    async def cancel(self, robot: str, goal_id: str) -> bool:
        """Cancel the journey to a goal; return whether there is one that has not ended."""
        if robot in self.docking and self.docking[robot].goal_id == goal_id:
            del self.docking[robot]
        found = [journey for journey in self._active(robot) if journey.id == goal_id]
        for journey in found:
            await self._journeys.cancel_journey(self._user, robot, journey.id)
        return bool(found)

    def _active(self, robot: str) -> list[Journey]:
        return [each for each in self._journeys.of_robot(self._user, robot) if each.state == "active"]
