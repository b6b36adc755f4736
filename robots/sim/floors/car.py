"""Car of a simulated lift: its doorways on the floors, and the robots and people that it carries between them."""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence

from ppaas.buildings.building import Building
from ppaas.buildings.layout import Landing
from ppaas.buildings.lifts.simulated import SimulatedLift
from ppaas.buildings.riding.car_frame import carried, is_inside
from ppaas.geometry import Pose2D
from robots.sim.floors.doorway import Doorway
from robots.sim.pedestrian import Pedestrian
from robots.sim.robot import SimulatedRobot
from robots.sim.shortest_paths import ShortestPaths
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
    paths : callable
        Returns the paths of people on a floor.
    """

    def __init__(
        self,
        building: Building,
        lift: SimulatedLift,
        landings: Sequence[Landing],
        worlds: Mapping[str, World],
        paths: Callable[[str], ShortestPaths],
    ) -> None:
        self.lift, self._paths = lift, paths
        self._building, self._worlds = building, worlds
        self._landings = {landing.floor: landing for landing in reversed(landings)}
        self._doorways: defaultdict[str, list[Doorway]] = defaultdict(list)
        for landing in landings:
            self._doorways[landing.floor].append(Doorway(worlds[landing.floor], landing.door.ends))
        self._floor = ""

    def stands_open_at(self, floor: str, now: float) -> bool:
        """Return whether the car stands open at a floor."""
        state = self.lift.state(now)
        return (state.floor, state.motion, state.door) == (floor, "stopped", "open")

    def carries(self, robot: SimulatedRobot) -> bool:
        """Return whether a robot is in the car."""
        return robot in self._riders()

    def has(self, person: Pedestrian) -> bool:
        """Return whether a person is in the car."""
        return person in self._people()

    @property
    def is_empty(self) -> bool:
        """Whether nobody is in the car."""
        return not self._riders() and not self._people()

    def _riders(self) -> list[SimulatedRobot]:
        landing = self._landings.get(self._floor)
        if landing is None:
            return []
        return [robot for robot in self._worlds[self._floor].robots if is_inside(landing, robot.base.pose)]

    def _people(self) -> list[Pedestrian]:
        landing = self._landings.get(self._floor)
        if landing is None:
            return []
        people = self._worlds[self._floor].pedestrians
        return [person for person in people if is_inside(landing, Pose2D(*person.body.position))]

    def step(self, now: float) -> None:
        """Follow the lift at a time [s]."""
        self.lift.blocked = any(doorway.is_blocked for doorway in self._doorways[self._floor])
        state = self.lift.state(now)
        if state.floor != self._floor:
            self._carry_to(state.floor)
        stands_open = self.stands_open_at(self._floor, now)
        for floor, doorways in self._doorways.items():
            for doorway in doorways:
                doorway.follow(stands_open and floor == self._floor)

    def _carry_to(self, floor: str) -> None:
        robots, people = self._riders(), self._people()
        origin, self._floor = self._floor, floor
        for robot in robots:
            pose = carried(self._building, self._landings[origin], self._landings[floor], robot.base.pose)
            self._worlds[floor].take_over(robot, self._worlds[origin], pose)
        for person in people:
            place = Pose2D(*person.body.position)
            pose = carried(self._building, self._landings[origin], self._landings[floor], place)
            self._worlds[floor].take_over_person(person, self._worlds[origin], self._paths(floor), pose)
