"""Round obstacles with a known velocity: other robots and people."""

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

Disc = tuple[float, float, float]
"""x, y and radius of a disc in the frame of the map [m]."""


class MovingObstacle(NamedTuple):
    """Round obstacle that moves, in the frame of the map.

    Parameters
    ----------
    x, y : float
        Position of the centre [m].
    vx, vy : float
        Velocity [m/s].
    radius : float
        [m].
    """

    x: float
    y: float
    vx: float
    vy: float
    radius: float

    def after(self, seconds: float) -> "MovingObstacle":
        """Return the obstacle after a time [s] at constant velocity."""
        return self._replace(x=self.x + seconds * self.vx, y=self.y + seconds * self.vy)


def swept_discs(movers: Iterable[MovingObstacle], seconds: float, robot: Disc) -> Iterator[Disc]:
    """Yield discs that cover the area which moving obstacles sweep, at most one radius apart.

    Future discs that touch the robot at its current position are left out: the robot must be able to leave, and the
    obstacle may still avoid it.

    Parameters
    ----------
    movers : iterable of MovingObstacle
        The obstacles.
    seconds : float
        Prediction horizon [s]; 0 yields the current discs only.
    robot : (x, y, radius)
        Disc of the robot itself.
    """
    for mover in movers:
        yield mover.x, mover.y, mover.radius
        distance = seconds * math.hypot(mover.vx, mover.vy)
        steps = math.ceil(distance / mover.radius) if mover.radius > 0.0 else 0
        for step in range(1, steps + 1):
            later = mover.after(seconds * step / steps)
            if math.hypot(later.x - robot[0], later.y - robot[1]) > later.radius + robot[2]:
                yield later.x, later.y, later.radius
