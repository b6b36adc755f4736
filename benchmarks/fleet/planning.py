"""Plans of a fleet: one plan for all robots, one with the time of turns, and new goals without end."""

import time
from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from benchmarks.fleet.cases import Case, drawn
from benchmarks.fleet.checking import faults_of
from benchmarks.harness.figures import Figure
from ppaas.errors import InvalidInput
from ppaas.fleet.first_plan import first_plan
from ppaas.fleet.improvement import Improvement, improved
from ppaas.fleet.kernels import neighbourhood
from ppaas.fleet.lifelong import LifelongPlan
from ppaas.fleet.plan import FleetPlan, timing_of, turns_of
from ppaas.fleet.problem import FleetProblem, distances_from
from ppaas.fleet.roadmap import Roadmap

ONE_SHOT = "one shot"
TIMES, QUICK_TIMES = (2.0, 10.0), (0.2,)
"""CPU times after which costs are told [s]."""

BASELINE_GOALS = 20
"""Number of goals whose distances scipy computes."""


def measure_one_shot(case: Case, quick: bool) -> Iterator[Figure]:
    """Plan for a case, and improve the plan; a plan with a fault misses its limit of 0 faults."""
    first_plan(case.read())  # loads the kernels
    began = time.process_time()
    problem = case.read()
    plan = first_plan(problem)
    spent = time.process_time() - began
    name, note = f"{case.name}, {len(problem)}", f"on {len(problem.roadmap)} cells"
    yield Figure(ONE_SHOT, f"{name}: first plan", round(spent, 3), "CPU s", note=f"{note}, reading included")
    yield Figure(ONE_SHOT, f"{name}: cost of it", _beside_bound(plan), "x", note=f"makespan {plan.makespan}")
    improvement = Improvement(problem, plan)
    best = plan
    for until in QUICK_TIMES if quick else TIMES:
        improvement.run(partial(_is_before, began + until))
        best = improvement.plan()
        yield Figure(
            ONE_SHOT, f"{name}: cost after {until:g} s", _beside_bound(best), "x", note="CPU time from the start"
        )
    faults = [*faults_in(problem, plan), *faults_in(problem, best)]
    yield Figure(ONE_SHOT, f"{name}: faults", len(faults), "", limit=0.0, note="; ".join(faults[:2]))
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
        raise InvalidInput("the distances differ from scipy's")
    note = "scipy.sparse.csgraph.dijkstra"
    return Figure(
        ONE_SHOT, f"{name}: distances from a goal", round(1e3 * spent / len(goals), 3), "ms", yardstick=True, note=note
    )


# -- one plan for all robots that take time to turn --------------------------------------------------------------------

TURNING = "turns"
UNTIL, QUICK_UNTIL = 2.0, 0.2
"""CPU time after which plans are timed [s]."""

MOVE, TURN = 1.0, 1.0
"""Time of a move and of a quarter turn [s]."""


def measure_turns(case: Case, quick: bool) -> Iterator[Figure]:
    """Time plans of a case that are improved without regard to turns and with it; turns take time in both."""
    until = QUICK_UNTIL if quick else UNTIL
    first_plan(case.read())  # loads the kernels
    neighbourhood.warm()
    for turn, how in ((0.0, "without turns"), (TURN / MOVE, "with turns")):
        began = time.process_time()
        problem = case.read()
        plan = improved(problem, first_plan(problem), 0, turn, partial(_part, began, until)).plan()
        name = f"{case.name}, {len(problem)}: {until:g} s {how}"
        yield _seconds(problem, plan, name)
        faults = faults_in(problem, plan)
        yield Figure(TURNING, f"{name}: faults", len(faults), "", limit=0.0, note="; ".join(faults[:2]))


def _part(began: float, until: float) -> float:
    """Return the part of a CPU time that has passed since another."""
    return (time.process_time() - began) / until


def _seconds(problem: FleetProblem, plan: FleetPlan, name: str) -> Figure:
    """Return the mean of the times at which robots are at their goals."""
    reached = timing_of(problem.roadmap, plan, np.full(len(problem), MOVE), TURN).times[-1]
    turns = int(turns_of(problem.roadmap, plan).sum())
    note = f"sum {reached.sum():g} s, last {reached.max():g} s; {turns} quarter turns, cost {plan.cost}"
    return Figure(TURNING, f"{name}: mean arrival", round(float(reached.mean()), 2), "s", note=note)


# -- robots that get a new goal each time that they have reached one ---------------------------------------------------

LIFELONG = "lifelong"
STEPS, QUICK_STEPS = 1000, 50

ALONE = 200
"""Number of cells whose mean distance from all others tells how many goals a robot alone would reach."""


def measure_lifelong(case: Case, quick: bool) -> Iterator[Figure]:
    """Extend the plan of the robots of a case step by step."""
    roadmap = case.read().roadmap
    starts, _ = drawn(roadmap, case.robots)
    plan, rng = LifelongPlan(roadmap, starts), np.random.default_rng(1)
    rows, ages, longest = [plan.cells], [], 0
    plan.extend()  # loads the kernels
    rows.append(plan.cells)
    began = time.process_time()
    steps = QUICK_STEPS if quick else STEPS
    for _ in range(steps):
        now = plan.ages
        for robot in np.nonzero(plan.cells == plan.goals)[0]:
            ages.append(int(now[robot]))
            plan.set_goal(int(robot), int(rng.choice(starts)))
        rows.append(plan.extend())
        longest = max(longest, int(plan.ages.max()))
    spent = time.process_time() - began
    reached = max(len(ages) - len(starts), 1)  # at first, each is where it wants to be
    name, mean = f"{case.name}, {len(starts)}", steps * len(starts) / reached
    alone = steps * len(starts) / _mean_way(roadmap, starts)
    faults = faults_of(roadmap, FleetPlan(np.array(rows), 0), rows[0].tolist(), rows[-1].tolist())
    yield Figure(
        LIFELONG,
        f"{name}: a step",
        round(1e3 * spent / steps, 3),
        "ms",
        note="CPU time, distances of new goals included",
    )
    yield Figure(
        LIFELONG, f"{name}: goals", round(reached / steps, 2), "a step", note=f"{reached / alone:.0%} of robots alone"
    )
    yield Figure(LIFELONG, f"{name}: longest open goal", longest, "steps", note=f"{longest / mean:.1f} × the mean")
    yield Figure(LIFELONG, f"{name}: faults", len(faults), "", limit=0.0, note="; ".join(faults[:2]))


def _mean_way(roadmap: Roadmap, cells: NDArray[np.int32]) -> float:
    return float(distances_from(roadmap, cells[:ALONE])[:, cells].mean())
