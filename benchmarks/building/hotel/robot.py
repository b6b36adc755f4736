"""Robot of the bench, as a site of journeys reaches it."""

import asyncio
from collections.abc import Callable, Mapping

from benchmarks.building.hotel.floor import FloorTraffic
from benchmarks.fleet.stand_ins.robot import PERIOD, TURN_RATE, StandIn
from engine.control.views import GoalView
from engine.specs.goal_states import GoalState
from ppaas.buildings.building import Building
from ppaas.buildings.layout import Place
from ppaas.errors import NotFound
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages.fleet.floors import FindFloorRequest, FindFloorResponse

MOVES = 0.1
"""Time from the order to go on on another map until the clone is ready there [s]."""


class HotelRobot:
    """Robot that drives on one floor after the other; implements ``Rider``.

    Parameters
    ----------
    name : str
    building : Building
    floors : mapping of str to FloorTraffic
        Traffic of each floor, by its name.
    floor : str
        Floor where it begins.
    pose : Pose2D
        Where it begins on the map of that floor.
    """

    def __init__(
        self, name: str, building: Building, floors: Mapping[str, FloorTraffic], floor: str, pose: Pose2D
    ) -> None:
        self.name, self.floor = name, floor
        self._building, self._floors = building, floors
        self._disc: StandIn | None = floors[floor].join(name, pose)
        self._goal, self._heading = "", 0.0
        self._sent: set[str] = set()
        self.ended: Callable[[GoalView], None] = lambda _: None

    @property
    def disc(self) -> StandIn | None:
        """Disc on the floor; None while its clone goes to another one."""
        return self._disc

    @property
    def is_here(self) -> bool:
        """Whether it is connected: always."""
        return True

    @property
    def map(self) -> str:
        """Map that its clone is on; empty while it goes to another one."""
        return "" if self._disc is None else self._building.floor(self.floor).map

    @property
    def pose(self) -> Place | None:
        """Its pose on that map."""
        return None if self._disc is None else (self._disc.pose.x, self._disc.pose.y, self._disc.pose.theta)

    def send(self, goal_id: str, pose: Place) -> None:
        """Send a goal, unless one of that id was sent; one that is driven to ends."""
        if goal_id in self._sent or self._disc is None:
            return
        self._sent.add(goal_id)
        if self._goal:
            self.cancel(self._goal)
        self._goal, self._heading = goal_id, pose[2]
        self._disc.goal, self._disc.goal_id = (pose[0], pose[1]), goal_id
        self._disc.goal_since = asyncio.get_running_loop().time()

    def cancel(self, goal_id: str) -> None:
        """Cancel a goal, if the robot drives to it."""
        if self._goal == goal_id and self._disc is not None:
            self._disc.goal, self._disc.goal_id = None, ""
            self._end("canceled", "it was cancelled")

    def note(self) -> None:
        """Notice that it is at its goal, where it turns first, or that the traffic has refused it."""
        disc = self._disc
        if not self._goal or disc is None or disc.goal_id:
            return
        if disc.refused:
            self._end("aborted", disc.refused.pop())
            return
        x, y, yaw = disc.pose
        off = wrap_angle(self._heading - yaw)
        turn = min(max(off, -TURN_RATE * PERIOD), TURN_RATE * PERIOD)
        disc.pose = Pose2D(x, y, wrap_angle(yaw + turn))
        if turn == off:
            self._end("succeeded", "")

    async def change_map(self, map_id: str, pose: Place) -> None:
        """Go on on another map."""
        floor = self._building.floor_of_map(map_id)
        assert floor is not None, "sites send robots to floors of the building"
        if floor.name == self.floor:
            return
        if self._goal:
            self.cancel(self._goal)
        self._floors[self.floor].leave(self.name)
        self._disc = None
        await asyncio.sleep(MOVES)
        self.floor = floor.name
        self._disc = self._floors[floor.name].join(self.name, Pose2D(*pose))

    async def find_floor(self, _request: FindFloorRequest) -> FindFloorResponse:
        """Refuse: it has no scans to compare with maps."""
        raise NotFound("laser", self.name)

    def leave(self) -> None:
        """Follow it no longer."""
        self.ended = lambda _: None

    def _end(self, state: GoalState, text: str) -> None:
        goal, self._goal = self._goal, ""
        asyncio.get_running_loop().call_soon(self.ended, GoalView(goal, (0.0, 0.0, 0.0), state, text, 0.0))
