"""Simulated building: a world for each floor, stepped together, with lifts and doors in one time."""

from collections import defaultdict
from collections.abc import Mapping

import numpy as np

from ppaas.buildings.doors.simulated import SimulatedDoor
from ppaas.buildings.layout import BuildingLayout
from ppaas.buildings.lifts.schedule import levels_of
from ppaas.buildings.lifts.simulated import LiftModel, SimulatedLift
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from robots.sim.contacts import ContactCounter
from robots.sim.floors.car import SimulatedCar
from robots.sim.floors.doorway import Doorway
from robots.sim.robot import SimulatedRobot, SimulatedRobotModel
from robots.sim.world import World


class SimulatedBuilding:
    """Building with robots, lifts and doors. The same seed and commands give the same simulation.

    Lifts and doors have the times of the record of the building. Doors for which it has no device stand open.

    Parameters
    ----------
    layout : BuildingLayout
        Record and places.
    grids : mapping of str to GridMap
        Map of each floor.
    seed : int
        Seed of all random numbers.
    dt : float
        Length of a step [s].
    bodies : bool
        Whether people have bodies, as in `World`.
    models : mapping of str to LiftModel, optional
        Models of lifts; by default of the record of the building.

    Attributes
    ----------
    floors : mapping of str to World
        World of each floor, in the order of the building, with the robots that are there now.
    robots : list of SimulatedRobot
        Robots of all floors, in the order in which they were added.
    lifts : mapping of str to SimulatedLift
    doors : mapping of (str, str) to SimulatedDoor
        By floor and name.
    contacts : ContactCounter
        Contacts on all floors, by the indices in ``robots``.

    Raises
    ------
    InvalidInput
        A floor has no map.
    """

    def __init__(
        self,
        layout: BuildingLayout,
        grids: Mapping[str, GridMap],
        seed: int = 0,
        dt: float = 0.02,
        *,
        bodies: bool = False,
        models: Mapping[str, LiftModel] | None = None,
    ) -> None:
        self.layout, self.dt, self.steps = layout, dt, 0
        self._epoch = 0.0
        self.contacts = ContactCounter(self.time)
        self.robots: list[SimulatedRobot] = []
        self.floors: dict[str, World] = {}
        for number, floor in enumerate(layout.building.floors):
            if floor.name not in grids:
                raise InvalidInput(f"floor {floor.name!r} has no map to simulate")
            own = int(np.random.SeedSequence((seed, number)).generate_state(1)[0])
            self.floors[floor.name] = World(grids[floor.name], own, dt, bodies=bodies, contacts=self.contacts)
        given = {} if models is None else models
        self.lifts = {lift: self._lift(lift, given.get(lift)) for lift in layout.landings}
        self.cars = {
            name: SimulatedCar(layout.building, lift, layout.landings[name], self.floors)
            for name, lift in self.lifts.items()
        }
        self.doors: dict[tuple[str, str], SimulatedDoor] = {}
        self._doorways: defaultdict[tuple[str, str], list[Doorway]] = defaultdict(list)
        self._add_doors()
        self._move_lifts_and_doors()

    def _lift(self, name: str, model: LiftModel | None) -> SimulatedLift:
        settings = self.layout.building.lift(name)
        stops = {landing.floor for landing in self.layout.landings[name]}
        levels = {floor: level for floor, level in levels_of(self.layout.building).items() if floor in stops}
        return SimulatedLift(name, levels, 0.0, model or LiftModel(speed=settings.speed, doors=settings.doors))

    def _add_doors(self) -> None:
        for place in self.layout.doors:
            settings = self.layout.building.door(place.floor, place.door)
            if settings.device and not place.lift:
                key = place.floor, place.door
                self.doors[key] = SimulatedDoor(*key, 0.0, settings.opens)
                self._doorways[key].append(Doorway(self.floors[place.floor], place.ends))

    @property
    def epoch(self) -> float:
        """Stamp of the start [seconds since the epoch]."""
        return self._epoch

    @epoch.setter
    def epoch(self, stamp: float) -> None:
        self._epoch = stamp
        for world in self.floors.values():
            world.epoch = stamp

    def time(self) -> float:
        """Return the simulated time since the start [s]."""
        return self.steps * self.dt

    def add_robot(
        self, pose: Pose2D, model: SimulatedRobotModel | None = None, floor: str | None = None
    ) -> SimulatedRobot:
        """Add a robot on a floor, by default the first one.

        Raises
        ------
        InvalidInput
            The pose is not finite, or the building has no such floor.
        """
        world = self.floors.get(next(iter(self.floors)) if floor is None else floor)
        if world is None:
            raise InvalidInput(f"there is no floor {floor!r}; the floors are {', '.join(self.floors)}")
        robot = world.add_robot(pose, model, len(self.robots))
        self.robots.append(robot)
        return robot

    def floor_of(self, robot: SimulatedRobot) -> str:
        """Return the floor on which a robot is; in a car, the nearest one."""
        return next(name for name, world in self.floors.items() if robot in world.robots)

    def step(self) -> None:
        """Simulate one step of all floors, lifts and doors."""
        self.steps += 1
        for world in self.floors.values():
            world.step()
        self._move_lifts_and_doors()

    def _move_lifts_and_doors(self) -> None:
        now = self.time()
        for car in self.cars.values():
            car.step(now)
        for key, door in self.doors.items():
            door.blocked = any(doorway.is_blocked for doorway in self._doorways[key])
            is_open = door.state(now).mode == "open"
            for doorway in self._doorways[key]:
                doorway.follow(is_open)
