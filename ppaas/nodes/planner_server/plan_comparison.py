"""Plan comparison: samples computed plans and compares their lengths with the cheapest, to evaluate planners."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

from ppaas import planners
from ppaas.costmap.costmap import Costmap
from ppaas.errors import PPaaSError
from ppaas.nodes.base import Context
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.planners.traits import Optimal
from ppaas.plans.reuse.processor import PlanProcessor

ONE_OF = 16
"""Sampling interval: of each planner's plans, the first of every `ONE_OF` is compared."""

TIMEOUT = 5.0
"""Time limit of the second plan [s]."""


class PlanComparison:
    """Plans sampled requests again with an optimal planner, after the reply was sent.

    Parameters
    ----------
    context : Context
        Context of the node that plans.
    processor : PlanProcessor
        Receives the results.
    """

    def __init__(self, context: Context, processor: PlanProcessor) -> None:
        self._context = context
        self._processor = processor
        self._planner: Planner | None = None
        self._seen: Counter[str] = Counter()
        self._running = False

    def see(self, planner: Planner, costmap: Costmap, request: PlanRequest, result: PlanResult) -> None:
        """Compare a plan if it is sampled."""
        if result.origin != "computed" or planner.traits.optimal is Optimal.ALWAYS:
            return  # not a new plan, or already the cheapest
        self._seen[planner.name] += 1
        if self._running or self._seen[planner.name] % ONE_OF != 1:
            return
        self._running = True
        cheapest_of = self._planner = self._planner or planners.create("dijkstra")

        def work(cancelled: Callable[[], bool]) -> PlanResult:
            return cheapest_of.plan(costmap, replace(request, cancelled=cancelled, timeout=TIMEOUT))

        def done(cheapest: PlanResult | PPaaSError) -> None:
            self._running = False
            if isinstance(cheapest, PlanResult):  # an error means a timeout, or a stricter check of the footprint
                self._processor.compared(planner, request, result.length, cheapest.length)

        self._context.start(work, done)
