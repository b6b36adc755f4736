"""Compares some of the plans that are computed with the cheapest ones, for the evaluation of planners."""

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
"""Plans of one planner of which one is compared: the first, and then each of so many."""

TIMEOUT = 5.0


class PlanComparison:
    """Has a planner of cheapest paths plan again what another has planned, when nobody waits for it any more.

    Parameters
    ----------
    context : Context
        Of the node that plans.
    processor : PlanProcessor
        Told how the two compare.
    """

    def __init__(self, context: Context, processor: PlanProcessor) -> None:
        self._context = context
        self._processor = processor
        self._planner: Planner | None = None
        self._seen: Counter[str] = Counter()
        self._running = False

    def see(self, planner: Planner, costmap: Costmap, request: PlanRequest, result: PlanResult) -> None:
        """Compare a plan, if it is one of those that are to be."""
        if result.origin != "computed" or planner.traits.optimal is Optimal.ALWAYS:
            return  # those are the cheapest
        self._seen[planner.name] += 1
        if self._running or self._seen[planner.name] % ONE_OF != 1:
            return
        self._running = True
        cheapest_of = self._planner = self._planner or planners.create("dijkstra")

        def work(cancelled: Callable[[], bool]) -> PlanResult:
            return cheapest_of.plan(costmap, replace(request, cancelled=cancelled, timeout=TIMEOUT))

        def done(cheapest: PlanResult | PPaaSError) -> None:
            self._running = False
            if isinstance(cheapest, PlanResult):  # else it met an obstacle that the other need not heed, or took long
                self._processor.compared(planner, request, result.length, cheapest.length)

        self._context.start(work, done)
