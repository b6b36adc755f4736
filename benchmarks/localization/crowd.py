"""People who crowd around a robot for a time: most of what its laser sees then is in no map."""

import math

import numpy as np
from numpy.typing import NDArray

from benchmarks.localization.route import Route
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.sim.robot import SimulatedRobot
from robots.sim.shortest_paths import TRIES, ShortestPaths
from robots.sim.world import World

NEAREST, FARTHEST = 0.5, 1.4
"""People stand so far from the robot, from middle to middle [m]."""
PACE, STAY = 0.4, 3.0
"""They step about as fast as this [m/s], and go for another place after so long, on average [s]."""
CREEP, TURN = 0.1, 0.6
"""What the robot does among them: it creeps along its way, or turns in place, as often as not [m/s, rad/s]."""
SHORTEST, LONGEST = 2.0, 6.0
"""It does one or the other for so long [s]."""


class Crowd:
    """People who mill about close around a robot. They keep out of its way, and nobody bumps into them.

    Parameters
    ----------
    robot : SimulatedRobot
    ways : ShortestPaths
        Where people may be.
    people : int
        How many.
    rng : numpy.random.Generator
        Their own.

    Attributes
    ----------
    places : (people, 2) array
        Where they are: x, y [m].
    """

    def __init__(self, robot: SimulatedRobot, ways: ShortestPaths, people: int, rng: np.random.Generator) -> None:
        self._robot, self._ways, self._rng = robot, ways, rng
        self._goals = np.array([self._place() for _ in range(people)])
        self.places = self._goals.copy()

    def _place(self) -> tuple[float, float]:
        """Return a place near the robot, off walls if there is one."""
        x, y, _ = self._robot.base.pose
        for _ in range(TRIES):
            away, bearing = self._rng.uniform((NEAREST, -math.pi), (FARTHEST, math.pi)).tolist()
            place = x + away * math.cos(bearing), y + away * math.sin(bearing)
            if self._ways.allows(*place):
                break
        return place

    def mill(self, dt: float) -> None:
        """Let everybody take a step of so long [s]."""
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
    """A world in which people may crowd around a robot, whom lasers see.

    Attributes
    ----------
    crowd : Crowd or None
    """

    crowd: Crowd | None = None

    def people(self) -> NDArray[np.float64]:
        """Return where people truly are, (n, 2) x, y [m]."""
        people = super().people()
        return people if self.crowd is None else np.concatenate((people, self.crowd.places))

    def step(self) -> None:
        """Let one step pass."""
        if self.crowd is not None:
            self.crowd.mill(self.dt)
        super().step()


class Inching:
    """How a robot drives among people: it creeps on, or looks for a way out by turning.

    Parameters
    ----------
    route : Route
        Where it wants to go.
    world : World
        Tells the time.
    rng : numpy.random.Generator
        Its own.
    """

    def __init__(self, route: Route, world: World, rng: np.random.Generator) -> None:
        self._route, self._world, self._rng = route, world, rng
        self._turn, self._until = 0.0, 0.0

    def steer(self, pose: Pose2D) -> Twist:
        """Return the velocity to go on at."""
        now = self._world.time()
        if now >= self._until:
            self._until = now + float(self._rng.uniform(SHORTEST, LONGEST))
            self._turn = TURN * float(self._rng.choice((-1, 0, 0, 1)))
        if self._turn:
            return Twist(Vector3(), Vector3(z=self._turn))
        on = self._route.steer(pose)
        return Twist(Vector3(x=min(on.linear.x, CREEP)), on.angular)
