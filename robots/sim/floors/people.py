"""People who use the lifts of a simulated building: they walk about, call a car, ride, and get out."""

from collections.abc import Iterator

import numpy as np

from ppaas.buildings.layout import Landing
from ppaas.geometry import Pose2D
from robots.sim.actors import Activity, Actor, Script, Stay, StepTo, Walk
from robots.sim.floors.building import SimulatedBuilding

PATIENCE = 90.0
"""Time after which somebody who waits for a lift goes elsewhere [s]."""

LOOK = 0.3
"""Time between two looks at the doors of a lift [s]."""

ASIDE = 0.8
"""Distance from a robot's place before a lift to where people wait on the left, and get out on the right [m]."""


class LiftUser:
    """Person who goes from floor to floor.

    Parameters
    ----------
    building : SimulatedBuilding
    floor : str
        Floor on which the person begins, at a random place.
    number : int
        Number of the person, which its random choices depend on.
    longest_stay : float
        Longest stay at a place [s].

    Attributes
    ----------
    person : Actor
    rides : int
        Rides that have ended.
    """

    def __init__(self, building: SimulatedBuilding, floor: str, number: int, longest_stay: float = 10.0) -> None:
        self.rides = 0
        self._building, self._longest_stay = building, longest_stay
        self._rng = np.random.default_rng((number, 4))
        paths = building.paths(floor)
        self.person: Actor = building.floors[floor].add_actor(paths, paths.anywhere(), self._script())

    @property
    def floor(self) -> str:
        """Floor on which the person is; in a car, the nearest one."""
        return next(name for name, world in self._building.floors.items() if self.person in world.pedestrians)

    def _script(self) -> Script:
        while True:
            yield Walk(self._building.paths(self.floor).anywhere())
            yield Stay(float(self._rng.uniform(0.0, self._longest_stay)))
            trips = self._trips(self.floor)
            if trips:
                yield from self._ride(*trips[self._rng.integers(len(trips))])

    def _trips(self, floor: str) -> list[tuple[Landing, Landing]]:
        """Return the landings on a floor, each with one where its lift may be left."""
        lifts = self._building.layout.landings.values()
        pairs = ((here, there) for each in lifts for here in each for there in each)
        return [(here, there) for here, there in pairs if here.floor == floor != there.floor]

    def _ride(self, here: Landing, there: Landing) -> Iterator[Activity]:
        yield Walk(Pose2D(*here.wait) @ Pose2D(0.0, ASIDE))
        gives_up = self._building.time() + PATIENCE
        while not self._may_enter(here):
            if self._building.time() > gives_up:
                return
            self._call(here, there)
            yield Stay(LOOK, here.wait[2])
        for place in (here.door.middle, here.car):
            if not self._call(here, there):  # the doors stay open for another moment
                return
            yield StepTo(*place[:2])
        yield from self._leave(there)

    def _call(self, here: Landing, there: Landing) -> bool:
        """Call the lift, or hold it; return whether it has this trip."""
        return self._building.lifts[here.lift].call(here.floor, there.floor, self._building.time())

    def _may_enter(self, here: Landing) -> bool:
        """Return whether the car stands open for people, and nobody is in it."""
        now = self._building.time()
        car = self._building.cars[here.lift]
        is_ours = self._building.lifts[here.lift].state(now).mode == "human"
        return is_ours and car.stands_open_at(here.floor, now) and car.is_empty

    def _leave(self, there: Landing) -> Iterator[Activity]:
        """Ride to where the doors open next on another floor, and step out."""
        origin, car = self.floor, self._building.cars[there.lift]
        while (here := self._landing_around()) is not None:
            now = self._building.time()
            if here.floor != origin and car.stands_open_at(here.floor, now):
                yield StepTo(*here.door.middle)
                yield StepTo(*(Pose2D(*here.wait) @ Pose2D(0.0, -ASIDE))[:2])
                self.rides += 1
                return
            if here.floor == origin and car.lift.state(now).mode == "agv":
                self._call(here, there)  # again, since its trip has been given up
            yield Stay(LOOK, here.car[2])

    def _landing_around(self) -> Landing | None:
        """Return the landing of the car in which the person is."""
        return next(
            (each for name, car in self._building.cars.items() for each in self._building.layout.landings[name]
             if each.floor == self.floor and car.has(self.person)),
            None,
        )  # fmt: skip
