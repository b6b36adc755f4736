"""Scorer: compares the robots' true poses with their goals. No other code reads the true poses."""

from ppaas.geometry import Pose2D
from robots.sim.world import World


class Scorer:
    """Scores the robots of a world.

    Parameters
    ----------
    world : World
        World with the robots, which are identified by index.
    """

    def __init__(self, world: World) -> None:
        self._world = world

    def error(self, robot: int, goal: Pose2D) -> float:
        """Return the true distance of a robot to a goal [m]."""
        return self._world.robots[robot].base.pose.distance_to(goal)

    def distance(self, robot: int) -> float:
        """Return the true distance that a robot has travelled [m]."""
        return self._world.robots[robot].base.travelled

    def collisions(self, robot: int) -> int:
        """Return the number of contacts of a robot."""
        return self._world.contacts.total(robot)
