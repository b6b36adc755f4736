"""Car of a simulated lift: its doorways on the floors, and the robots that it carries between them."""

from collections import defaultdict
from collections.abc import Mapping, Sequence

from ppaas.buildings.building import Building
from ppaas.buildings.layout import Landing
from ppaas.buildings.lifts.simulated import SimulatedLift
from ppaas.buildings.riding.car_frame import carried, is_inside
from robots.sim.floors.doorway import Doorway
from robots.sim.robot import SimulatedRobot
from robots.sim.world import World


class SimulatedCar:
    """Car of a lift.

    Robots in a moving car are on the floor that is nearest to it, as the lift reports it: they see the walls of the car
    as they are drawn on that map, and its closed doors.

    Parameters
    ----------
    building : Building
    lift : SimulatedLift
    landings : sequence of Landing
        Landings of the lift; a floor may have several.
    worlds : mapping of str to World
        World of each floor.
    """

    def __init__(
        self, building: Building, lift: SimulatedLift, landings: Sequence[Landing], worlds: Mapping[str, World]
    ) -> None:
        self.lift = lift
        self._building, self._worlds = building, worlds
        self._landings = {landing.floor: landing for landing in reversed(landings)}
        self._doorways: defaultdict[str, list[Doorway]] = defaultdict(list)
        for landing in landings:
            self._doorways[landing.floor].append(Doorway(worlds[landing.floor], landing.door.ends))
        self._floor = ""

    def riders(self) -> list[SimulatedRobot]:
        """Return the robots in the car."""
        landing = self._landings.get(self._floor)
        if landing is None:
            return []
        return [robot for robot in self._worlds[self._floor].robots if is_inside(landing, robot.base.pose)]

    def step(self, now: float) -> None:
        """Follow the lift at a time [s]."""
        self.lift.blocked = any(doorway.is_blocked for doorway in self._doorways[self._floor])
        state = self.lift.state(now)
        if state.floor != self._floor:
            self._carry_to(state.floor)
        stands_open = state.motion == "stopped" and state.door == "open"
        for floor, doorways in self._doorways.items():
            for doorway in doorways:
                doorway.follow(stands_open and floor == self._floor)

    def _carry_to(self, floor: str) -> None:
        riders = self.riders()
        origin, self._floor = self._floor, floor
        for robot in riders:
            pose = carried(self._building, self._landings[origin], self._landings[floor], robot.base.pose)
            self._worlds[floor].take_over(robot, self._worlds[origin], pose)
