"""One plan for all robots that take time to turn: improved without regard to turns, and with it."""

import time
from collections.abc import Iterator
from functools import partial

import numpy as np

from benchmarks.fleet.cases import Case
from benchmarks.fleet.one_shot import faults_in
from benchmarks.harness.figures import Figure
from ppaas.fleet.first_plan import first_plan
from ppaas.fleet.improvement import improved
from ppaas.fleet.kernels import neighbourhood
from ppaas.fleet.plan import FleetPlan, timing_of, turns_of
from ppaas.fleet.problem import FleetProblem

PART = "turns"
UNTIL, QUICK_UNTIL = 2.0, 0.2
"""CPU time after which plans are timed [s]."""

MOVE, TURN = 1.0, 1.0
"""Time of a move and of a quarter turn [s]."""


def measure(case: Case, quick: bool) -> Iterator[Figure]:
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
        yield Figure(PART, f"{name}: faults", len(faults), "", limit=0.0, note="; ".join(faults[:2]))


def _part(began: float, until: float) -> float:
    """Return the part of a CPU time that has passed since another."""
    return (time.process_time() - began) / until


def _seconds(problem: FleetProblem, plan: FleetPlan, name: str) -> Figure:
    """Return the mean of the times at which robots are at their goals."""
    reached = timing_of(problem.roadmap, plan, np.full(len(problem), MOVE), TURN).times[-1]
    turns = int(turns_of(problem.roadmap, plan).sum())
    note = f"sum {reached.sum():g} s, last {reached.max():g} s; {turns} quarter turns, cost {plan.cost}"
    return Figure(PART, f"{name}: mean arrival", round(float(reached.mean()), 2), "s", note=note)
