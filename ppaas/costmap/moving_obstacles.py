"""Round things that move in a known way: robots that share where they drive."""

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

Disc = tuple[float, float, float]
"""x, y and radius of something round in the frame of the map [m]."""


class MovingObstacle(NamedTuple):
    """Where something round is, in the frame of the map, and how fast it goes there.

    Parameters
    ----------
    x, y : float
        Of its middle [m].
    vx, vy : float
        [m/s].
    radius : float
        [m].
    """

    x: float
    y: float
    vx: float
    vy: float
    radius: float

    def after(self, seconds: float) -> "MovingObstacle":
        """Return where it will be if it goes on so."""
        return self._replace(x=self.x + seconds * self.vx, y=self.y + seconds * self.vy)


def swept_discs(movers: Iterable[MovingObstacle], seconds: float, robot: Disc) -> Iterator[Disc]:
    """Yield what movers take up from now on, as discs a radius apart from each other.

    Where one would touch the robot, as that stands now, it is not told of: a robot must be able to leave, and the other
    may still avoid it.

    Parameters
    ----------
    movers : iterable of MovingObstacle
    seconds : float
        How far ahead; 0 for where they are now.
    robot : (x, y, radius)
        The robot whom it is told to.
    """
    for mover in movers:
        yield mover.x, mover.y, mover.radius
        way = seconds * math.hypot(mover.vx, mover.vy)
        steps = math.ceil(way / mover.radius) if mover.radius > 0.0 else 0
        for step in range(1, steps + 1):
            there = mover.after(seconds * step / steps)
            if math.hypot(there.x - robot[0], there.y - robot[1]) > there.radius + robot[2]:
                yield there.x, there.y, there.radius
