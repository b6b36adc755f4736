"""What a container has measured of planning and of finding kept plans: both sides of criterion (a)."""

from dataclasses import dataclass, field

from ppaas.clock import monotonic
from ppaas.plans.reuse.time_estimates import ComputationTimes, Estimate, LinkTimes

BYTES_PER_CELL = 64.0
"""Of an answer, for each cell between start and goal: a pose has 56 bytes, and no path is straight."""

TOLD_PER_CELL = 1.4e-6
"""Seconds, for each cell between start and goal, until a plan is told to whoever asked, as JSON: some 110 bytes a pose.

That way is not measured here. Computed plans go it as well, so what is saved is less than what planning takes.
"""

CHECKING = 2e-4
CHECKED_PER_SECOND = 1e9
"""What is believed of checking a plan before it was measured: how long any takes [s], and bytes of poses [1/s]."""

LEAST = Estimate(3e-4, 3e-4, 3e-4, 0.0)
"""No kept plan is ever there sooner: a frame to the machine and back, a thread there, and a store."""


@dataclass(slots=True)
class Times:
    """What was measured, for the estimates of criterion (a)."""

    computation: ComputationTimes = field(default_factory=ComputationTimes)
    link: LinkTimes = field(default_factory=LinkTimes)
    checking: LinkTimes = field(default_factory=lambda: LinkTimes(monotonic, CHECKING, CHECKED_PER_SECOND))

    def transmission(self, cells: float) -> Estimate:
        """Return how long it will take until a kept plan of this complexity is there, was checked and is told."""
        size = cells * BYTES_PER_CELL
        link, checking = self.link.expect(size), self.checking.expect(size)
        told = cells * TOLD_PER_CELL
        lower, upper = link.lower + checking.lower + told, link.upper + checking.upper + told
        return Estimate(link.mean + checking.mean + told, lower, upper, link.samples)
