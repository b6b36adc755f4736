"""Times of planning and of finding stored plans, as measured by a container: both sides of criterion (a)."""

from dataclasses import dataclass, field

from ppaas.clock import monotonic
from ppaas.plans.reuse.time_estimates import ComputationTimes, Estimate, LinkTimes

BYTES_PER_CELL = 64.0
"""Size of an answer per cell between start and goal [bytes]: a pose has 56 bytes, and no path is straight."""

JSON_SECONDS_PER_CELL = 1.4e-6
"""Time to send a plan to the client as JSON, per cell between start and goal [s]. A pose has about 110 bytes.

This time is not measured here. Computed plans need it too, so reuse saves less than the time of planning."""

CHECK_SECONDS = 2e-4
"""Assumed time to check any plan, before the first measurement [s]."""

CHECK_BYTES_PER_SECOND = 1e9
"""Assumed rate at which poses are checked, before the first measurement [bytes/s]."""

FASTEST_RETRIEVAL = Estimate(3e-4, 3e-4, 3e-4, 0.0)
"""Lower limit of the time to get a stored plan [s]: a frame to the machine and back, a thread there, and a store."""


@dataclass(slots=True)
class Times:
    """Measured times, for the estimates of criterion (a)."""

    computation: ComputationTimes = field(default_factory=ComputationTimes)
    link: LinkTimes = field(default_factory=LinkTimes)
    checking: LinkTimes = field(default_factory=lambda: LinkTimes(monotonic, CHECK_SECONDS, CHECK_BYTES_PER_SECOND))

    def transmission(self, cells: float) -> Estimate:
        """Return the estimated time to find, check and send a stored plan of this complexity [cells]."""
        size = cells * BYTES_PER_CELL
        link, checking = self.link.expect(size), self.checking.expect(size)
        serializing = cells * JSON_SECONDS_PER_CELL
        lower, upper = link.lower + checking.lower + serializing, link.upper + checking.upper + serializing
        return Estimate(link.mean + checking.mean + serializing, lower, upper, link.samples)
