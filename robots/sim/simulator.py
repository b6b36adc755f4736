"""Runs a simulated world in real time."""

import asyncio
import math

from ppaas.clock import Clock, epoch, monotonic
from robots.sim.world import World

BURST = 25
"""Steps taken at once to catch up, before others may run."""


class Simulator:
    """Steps a world so that its time keeps up with the clock, in one asyncio task for all its robots.

    Each step is due at its own moment since the start, so rounding never adds up; a world that was held up catches up.

    Parameters
    ----------
    world : World
        Its stamps begin with the present moment when this is made.
    clock, stamp_clock : callable
        Monotonic seconds; seconds since the epoch.
    """

    def __init__(self, world: World, clock: Clock = monotonic, stamp_clock: Clock = epoch) -> None:
        self._world = world
        self._clock = clock
        self._origin = clock() - world.time()
        world.epoch = stamp_clock() - world.time()

    def due(self) -> int:
        """Return how many steps the world is behind."""
        return max(math.floor((self._clock() - self._origin) / self._world.dt) - self._world.steps, 0)

    def catch_up(self) -> int:
        """Take the steps that are due, but not more than a burst; return how many."""
        steps = min(self.due(), BURST)
        for _ in range(steps):
            self._world.step()
        return steps

    async def run(self) -> None:
        """Keep up until cancelled."""
        while True:
            self.catch_up()
            next_due = self._origin + (self._world.steps + 1) * self._world.dt
            await asyncio.sleep(max(next_due - self._clock(), 0.0))
