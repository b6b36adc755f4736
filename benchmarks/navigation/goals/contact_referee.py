"""Who touches whom, and whose doing it is."""

from dataclasses import dataclass

import numpy as np

from robots.sim.robot import SimulatedRobot
from robots.sim.world import World

MOVES = 0.05
"""A robot that comes nearer to whom it touches by more than this has caused it [m/s]."""

TOUCH = 0.005
"""Outlines that are no farther apart touch [m]: what collides is held a millimetre apart."""


@dataclass(slots=True)
class Touches:
    """What happened so far.

    Parameters
    ----------
    walls : int
        Touches of walls.
    caused : int
        Touches of people to whom the robot moved.
    suffered : int
        Touches by people while it stood, or moved away.
    nearest : float
        Least distance from outline to outline while the robot moved [m].
    """

    walls: int = 0
    caused: int = 0
    suffered: int = 0
    nearest: float = np.inf


class Referee:
    """Watches one robot, step by step.

    A touch of a person begins when the outlines come together and ends when they part. It is the robot's doing if, at
    any moment of it, the robot drives towards the person at more than ``MOVES``; whatever the person does.

    Parameters
    ----------
    world : World
    robot : SimulatedRobot
        Its first.
    """

    def __init__(self, world: World, robot: SimulatedRobot) -> None:
        self.touches = Touches()
        self._world = world
        self._robot = robot
        self._touching: dict[int, bool] = {}
        self._walls_before = 0

    def begin(self) -> Touches:
        """Count anew; return what is counted from now on."""
        self.touches = Touches()
        self._walls_before = self._world.contacts.wall_contacts[0]
        return self.touches

    def look(self) -> None:
        """Look at what the last step brought."""
        touches, base = self.touches, self._robot.base
        touches.walls = self._world.contacts.wall_contacts[0] - self._walls_before
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
