"""Real-time simulation: steps a world in time with the clock."""

import asyncio
import math
from collections.abc import Callable
from typing import Protocol

from ppaas.clock import Clock, epoch, monotonic

BURST = 25
"""Largest number of steps taken at once to catch up, before other tasks run."""


class Stepped(Protocol):
    """What is simulated: a world, or a building."""

    dt: float
    steps: int
    epoch: float

    def time(self) -> float:
        """Return the simulated time since the start [s]."""
        ...

    def step(self) -> None:
        """Simulate one step."""
        ...


class Simulator:
    """Steps a world so that its time follows the clock, in one asyncio task for all robots.

    The due time of each step is computed from the start, so rounding errors do not add up. A delayed world catches up.

    Parameters
    ----------
    world : World or SimulatedBuilding
        What is stepped; its stamps start at the current time.
    clock, stamp_clock : callable
        Monotonic time [s]; time since the epoch [s].
    after_step : callable, optional
        Called after each step of the world.
    """

    def __init__(
        self,
        world: Stepped,
        clock: Clock = monotonic,
        stamp_clock: Clock = epoch,
        *,
        after_step: Callable[[], None] = lambda: None,
    ) -> None:
        self._world = world
        self._clock = clock
        self._after_step = after_step
        self._origin = clock() - world.time()
        world.epoch = stamp_clock() - world.time()

    def due(self) -> int:
        """Return the number of steps that are due."""
        return max(math.floor((self._clock() - self._origin) / self._world.dt) - self._world.steps, 0)

    def catch_up(self) -> int:
        """Take the due steps, at most ``BURST``; return their number."""
        steps = min(self.due(), BURST)
        for _ in range(steps):
            self._world.step()
            self._after_step()
        return steps

    async def run(self) -> None:
        """Step the world in real time until cancelled."""
        while True:
            self.catch_up()
            next_due = self._origin + (self._world.steps + 1) * self._world.dt
            await asyncio.sleep(max(next_due - self._clock(), 0.0))
