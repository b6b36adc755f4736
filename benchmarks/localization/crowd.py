"""Crowd of people around a robot: most of its laser beams then hit people instead of the map."""

import math

import numpy as np
from numpy.typing import NDArray

from benchmarks.localization.route import RandomRoute
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.sim.robot import SimulatedRobot
from robots.sim.shortest_paths import TRIES, ShortestPaths
from robots.sim.world import World

NEAREST, FARTHEST = 0.5, 1.4
"""Smallest and largest distance of people from the robot, centre to centre [m]."""
PACE, STAY = 0.4, 3.0
"""Walking speed of people [m/s], and mean time until a person chooses another place [s]."""
CREEP, TURN = 0.1, 0.6
"""Speed of the robot along its path, and when it turns in place, each half of the time [m/s, rad/s]."""
SHORTEST, LONGEST = 2.0, 6.0
"""Shortest and longest time until the robot chooses between the two again [s]."""


class Crowd:
    """People who walk close around a robot. They step aside for it and take part in no collision.

    Parameters
    ----------
    robot : SimulatedRobot
    ways : ShortestPaths
        Free space for people.
    people : int
        Number of people.
    rng : numpy.random.Generator
        Random source of the crowd.

    Attributes
    ----------
    places : (people, 2) array
        Positions x, y of the people [m].
    """

    def __init__(self, robot: SimulatedRobot, ways: ShortestPaths, people: int, rng: np.random.Generator) -> None:
        self._robot, self._ways, self._rng = robot, ways, rng
        self._goals = np.array([self._place() for _ in range(people)])
        self.places = self._goals.copy()

    def _place(self) -> tuple[float, float]:
        """Return a random place near the robot, in free space if one is found."""
        x, y, _ = self._robot.base.pose
        for _ in range(TRIES):
            away, bearing = self._rng.uniform((NEAREST, -math.pi), (FARTHEST, math.pi)).tolist()
            place = x + away * math.cos(bearing), y + away * math.sin(bearing)
            if self._ways.allows(*place):
                break
        return place

    def mill(self, dt: float) -> None:
        """Move all people for a time step [s]."""
        for person in np.flatnonzero(self._rng.random(len(self.places)) < dt / STAY):
            self._goals[person] = self._place()
        left = self._goals - self.places
        far = np.hypot(*left.T)[:, np.newaxis]
        self.places = self.places + left * np.minimum(1.0, PACE * dt / np.maximum(far, 1e-9))
        self._step_aside()

    def _step_aside(self) -> None:
        middle = np.array(self._robot.base.pose[:2])
        away = self.places - middle
        near = np.maximum(np.hypot(*away.T)[:, np.newaxis], 1e-9)
        self.places = middle + away * np.maximum(1.0, NEAREST / near)


class CrowdedWorld(World):
    """A world with an optional crowd, which lasers see.

    Attributes
    ----------
    crowd : Crowd or None
    """

    crowd: Crowd | None = None

    def people(self) -> NDArray[np.float64]:
        """Return the true positions (n, 2) x, y of all people [m]."""
        people = super().people()
        return people if self.crowd is None else np.concatenate((people, self.crowd.places))

    def step(self) -> None:
        """Simulate one time step."""
        if self.crowd is not None:
            self.crowd.mill(self.dt)
        super().step()


class Inching:
    """Motion of a robot in a crowd: it creeps along its route or turns in place.

    Parameters
    ----------
    route : RandomRoute
        Route of the robot.
    world : World
        Source of the time.
    rng : numpy.random.Generator
        Random source of the choices.
    """

    def __init__(self, route: RandomRoute, world: World, rng: np.random.Generator) -> None:
        self._route, self._world, self._rng = route, world, rng
        self._turn, self._until = 0.0, 0.0

    def steer(self, pose: Pose2D) -> Twist:
        """Return the velocity at a pose."""
        now = self._world.time()
        if now >= self._until:
            self._until = now + float(self._rng.uniform(SHORTEST, LONGEST))
            self._turn = TURN * float(self._rng.choice((-1, 0, 0, 1)))
        if self._turn:
            return Twist(Vector3(), Vector3(z=self._turn))
        on = self._route.steer(pose)
        return Twist(Vector3(x=min(on.linear.x, CREEP)), on.angular)
