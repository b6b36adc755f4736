"""Sampled plans of planners that are not always optimal are compared with the cheapest."""

from ppaas import planners
from ppaas.nodes.graph import Graph
from ppaas.nodes.planner_server.plan_comparison import ONE_OF, PlanComparison
from ppaas.planners.base import PlanRequest
from ppaas.plans.history import PlannerHistory
from ppaas.plans.reuse.setup import ReuseSetup
from tests.support.world.grids import centre, costmap

MAP = costmap("\n".join(["." * 40] * 30))
REQUEST = PlanRequest(centre(MAP, 1, 1), centre(MAP, 20, 38))


class ComparisonHarness:
    """A plan comparison on a graph that runs jobs at once."""

    def __init__(self) -> None:
        self.noted = list[PlannerHistory]()
        self.comparison = PlanComparison(Graph(), ReuseSetup("house", "v1", note=self.noted.append).processor(MAP, 0.2))

    def see(self, planner: str, times: int = 1) -> None:
        chosen = planners.create(planner)
        for _ in range(times):
            self.comparison.see(chosen, MAP, REQUEST, chosen.plan(MAP, REQUEST))


def test_first_plan_and_every_nth_are_compared() -> None:
    harness = ComparisonHarness()
    harness.see("theta_star")
    (row,) = harness.noted
    assert (row.planner, row.compared, row.queries) == ("theta_star", 1, 0)
    assert 0 < row.millimetres < row.cheapest_millimetres, "a straight line is shorter than one from cell to cell"
    harness.see("theta_star", ONE_OF)
    assert len(harness.noted) == 2


def test_optimal_planner_is_not_compared() -> None:
    harness = ComparisonHarness()
    harness.see("dijkstra", 2)
    assert harness.noted == []
