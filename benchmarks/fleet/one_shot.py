"""One plan for all robots: CPU time and cost of the first one, and cost after more time."""

import time
from collections.abc import Iterator
from functools import partial

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from benchmarks.fleet.cases import Case
from benchmarks.fleet.checking import faults_of
from benchmarks.harness.figures import Figure
from ppaas.errors import InvalidInput
from ppaas.fleet.first_plan import first_plan
from ppaas.fleet.improvement import Improvement
from ppaas.fleet.plan import FleetPlan
from ppaas.fleet.problem import FleetProblem

PART = "one shot"
TIMES, QUICK_TIMES = (2.0, 10.0), (0.2,)
"""CPU times after which costs are told [s]."""

BASELINE_GOALS = 20
"""Number of goals whose distances scipy computes."""


def measure(case: Case, quick: bool) -> Iterator[Figure]:
    """Plan for a case, and improve the plan; a plan with a fault misses its limit of 0 faults."""
    first_plan(case.read())  # loads the kernels
    began = time.process_time()
    problem = case.read()
    plan = first_plan(problem)
    spent = time.process_time() - began
    name, note = f"{case.name}, {len(problem)}", f"on {len(problem.roadmap)} cells"
    yield Figure(PART, f"{name}: first plan", round(spent, 3), "CPU s", note=f"{note}, reading included")
    yield Figure(PART, f"{name}: cost of it", _beside_bound(plan), "x", note=f"makespan {plan.makespan}")
    improvement = Improvement(problem, plan)
    best = plan
    for until in QUICK_TIMES if quick else TIMES:
        improvement.run(partial(_is_before, began + until))
        best = improvement.plan()
        yield Figure(PART, f"{name}: cost after {until:g} s", _beside_bound(best), "x", note="CPU time from the start")
    faults = [*faults_in(problem, plan), *faults_in(problem, best)]
    yield Figure(PART, f"{name}: faults", len(faults), "", limit=0.0, note="; ".join(faults[:2]))
    yield _baseline(problem, name)


def _is_before(end: float) -> bool:
    """Return whether the CPU time of the process is before an end [s]."""
    return time.process_time() < end


def _beside_bound(plan: FleetPlan) -> float:
    return round(plan.cost / max(plan.bound, 1), 3)


def faults_in(problem: FleetProblem, plan: FleetPlan) -> list[str]:
    """Return all that is wrong with a plan."""
    return faults_of(problem.roadmap, plan, problem.starts.tolist(), problem.goals.tolist())


def _baseline(problem: FleetProblem, name: str) -> Figure:
    """Return the CPU time of scipy for the distances from one goal; they must be ours."""
    cells, others = problem.roadmap.moves.T
    graph = csr_array((np.ones(len(cells)), (cells, others)), (len(problem.roadmap),) * 2)
    goals = problem.goals[:BASELINE_GOALS]
    began = time.process_time()
    found = dijkstra(graph, indices=goals, unweighted=True)
    spent = time.process_time() - began
    reached = np.isfinite(found)
    if not np.array_equal(found[reached], problem.distances[: len(goals)][reached]):
        raise InvalidInput("the distances are not those of scipy")
    note = "scipy.sparse.csgraph.dijkstra"
    return Figure(
        PART, f"{name}: distances from a goal", round(1e3 * spent / len(goals), 3), "ms", yardstick=True, note=note
    )
