"""Contacts of a robot with walls and people, and whether the robot caused them."""

from dataclasses import dataclass

import numpy as np

from robots.sim.robot import SimulatedRobot
from robots.sim.world import World

MOVES = 0.05
"""Speed of approach above which the robot has caused a contact [m/s]."""

TOUCH = 0.005
"""Largest gap between outlines that counts as a contact [m]: the physics keeps colliding bodies a millimetre apart."""


@dataclass(slots=True)
class Touches:
    """Number of contacts of a robot.

    Parameters
    ----------
    walls : int
        Contacts with walls.
    caused : int
        Contacts with people that the robot approached.
    suffered : int
        Contacts with people while the robot stood or moved away.
    nearest : float
        Smallest gap between the outlines of the robot and a person while the robot moved [m].
    """

    walls: int = 0
    caused: int = 0
    suffered: int = 0
    nearest: float = np.inf


class Referee:
    """Counts the contacts of a robot, step by step.

    A contact with a person lasts while the outlines touch. The robot has caused it if at any moment of it the robot
    drives towards the person at more than ``MOVES``, whatever the person does.

    Parameters
    ----------
    world : World
    robot : SimulatedRobot
        A robot of the world.
    """

    def __init__(self, world: World, robot: SimulatedRobot) -> None:
        self.touches = Touches()
        self._world = world
        self._robot = robot
        self._number = world.robots.index(robot)
        self._touching: dict[int, bool] = {}
        self._walls_before = 0

    def begin(self) -> Touches:
        """Start new counts and return them; ``look`` updates them."""
        self.touches = Touches()
        self._walls_before = self._world.contacts.wall_contacts[self._number]
        return self.touches

    def look(self) -> None:
        """Update the counts after a step of the world."""
        touches, base = self.touches, self._robot.base
        touches.walls = self._world.contacts.wall_contacts[self._number] - self._walls_before
        people = self._world.people()
        if not len(people):
            return
        to = people - np.array(base.body.position)
        distance = np.hypot(*to.T)
        gap = distance - base.model.radius - self._world.pedestrian_model.radius
        heading = np.array(base.body.rotation_vector)
        approach = base.wheels.linear * (to @ heading) / distance
        if abs(base.wheels.linear) > MOVES:
            touches.nearest = min(touches.nearest, float(gap.min()))
        self._judge(np.flatnonzero(gap <= TOUCH).tolist(), approach > MOVES)

    def _judge(self, near: list[int], approaching: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> None:
        before, self._touching = self._touching, {}
        for person in near:
            own = before.get(person)
            self._touching[person] = bool(own or approaching[person])
            if own is None:
                self.touches.suffered += 1
            if self._touching[person] and not own:
                self.touches.caused += 1
                self.touches.suffered -= 1
