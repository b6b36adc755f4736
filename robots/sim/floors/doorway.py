"""Doorway of a simulated floor: the barrier of a door, and who is in its way."""

from robots.sim.barrier import Segment
from robots.sim.world import World


class Doorway:
    """Doorway, which is closed at first.

    Parameters
    ----------
    world : World
        World of its floor.
    ends : Segment
        Line of its door.
    """

    def __init__(self, world: World, ends: Segment) -> None:
        self._world = world
        self._barrier = world.add_barrier(ends)
        self._barrier.close()

    @property
    def is_blocked(self) -> bool:
        """Whether a robot or a person is in the way of the door; nobody is once that is closed."""
        if self._barrier.is_closed:
            return False
        return any(self._barrier.is_blocked_by(places, radius) for places, radius in self._world.moving())

    def follow(self, is_open: bool) -> None:
        """Let its door stand open; or else be closed, also while it moves, once nobody is in the way."""
        if is_open:
            self._barrier.open()
        elif not self.is_blocked:
            self._barrier.close()
