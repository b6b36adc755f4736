"""The scorer: compares what robots were asked with where they truly are. No other reads the true pose."""

from ppaas.geometry import Pose2D
from robots.sim.world import World


class Scorer:
    """Judges the robots of a world.

    Parameters
    ----------
    world : World
        With its robots, which are called by their index.
    """

    def __init__(self, world: World) -> None:
        self._world = world

    def error(self, robot: int, goal: Pose2D) -> float:
        """Return the distance between where a robot truly is and where it should be [m]."""
        return self._world.robots[robot].base.pose.distance_to(goal)

    def distance(self, robot: int) -> float:
        """Return how far a robot has truly travelled [m]."""
        return self._world.robots[robot].base.travelled

    def collisions(self, robot: int) -> int:
        """Return how often a robot touched a wall or another robot."""
        return self._world.contacts.total(robot)
