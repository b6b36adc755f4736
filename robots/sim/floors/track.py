"""Track of a simulated building: where robots and cars were, for pictures of a run."""

from collections import defaultdict
from dataclasses import dataclass, field

from robots.sim.floors.building import SimulatedBuilding

PERIOD = 0.5
"""Time between two points of a track [s]."""

Point = tuple[float, float]


@dataclass(slots=True)
class RobotTrack:
    """Track of one robot.

    Parameters
    ----------
    heights : list of (float, float)
        Simulated time [s] and height [m].
    ways : dict of str to list of list of (float, float)
        By floor: the ways that it drove there without a break, as x, y [m].
    """

    heights: list[Point] = field(default_factory=list)
    ways: defaultdict[str, list[list[Point]]] = field(default_factory=lambda: defaultdict(list))


class BuildingTrack:
    """Records where the robots and the cars of a building are.

    Parameters
    ----------
    building : SimulatedBuilding
        With its robots.

    Attributes
    ----------
    robots : list of RobotTrack
        In the order of the robots of the building.
    cars : dict of str to list of (float, float)
        Simulated time [s] and height of the car [m] of each lift.
    """

    def __init__(self, building: SimulatedBuilding) -> None:
        self.robots = [RobotTrack() for _ in building.robots]
        self.cars: dict[str, list[Point]] = {name: [] for name in building.lifts}
        self._building = building
        self._floors = [""] * len(building.robots)
        self._due = 0.0

    def after_step(self) -> None:
        """Record a point if it is time, after a step of the building."""
        now = self._building.time()
        if now < self._due:
            return
        self._due = now + PERIOD
        for name, lift in self._building.lifts.items():
            self.cars[name].append((now, lift.height))
        for number, (robot, track) in enumerate(zip(self._building.robots, self.robots, strict=True)):
            floor, (x, y, _) = self._building.floor_of(robot), robot.base.pose
            track.heights.append((now, self._building.height_of(robot)))
            if floor != self._floors[number]:
                self._floors[number] = floor
                track.ways[floor].append([])
            track.ways[floor][-1].append((x, y))
