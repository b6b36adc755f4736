"""Robots that get a new goal each time that they have reached one: CPU time of a step, goals, and the longest wait."""

import time
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from benchmarks.fleet.cases import Case, drawn
from benchmarks.fleet.checking import faults_of
from benchmarks.harness.figures import Figure
from ppaas.fleet.lifelong import LifelongPlan
from ppaas.fleet.plan import FleetPlan
from ppaas.fleet.problem import distances_from
from ppaas.fleet.roadmap import Roadmap

PART = "lifelong"
STEPS, QUICK_STEPS = 1000, 50

ALONE = 200
"""Number of cells whose mean distance from all others tells how many goals a robot alone would reach."""


def measure(case: Case, quick: bool) -> Iterator[Figure]:
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
        PART, f"{name}: a step", round(1e3 * spent / steps, 3), "ms", note="CPU time, distances of new goals included"
    )
    yield Figure(
        PART, f"{name}: goals", round(reached / steps, 2), "a step", note=f"{reached / alone:.0%} of robots alone"
    )
    yield Figure(PART, f"{name}: longest open goal", longest, "steps", note=f"{longest / mean:.1f} × the mean")
    yield Figure(PART, f"{name}: faults", len(faults), "", limit=0.0, note="; ".join(faults[:2]))


def _mean_way(roadmap: Roadmap, cells: NDArray[np.int32]) -> float:
    return float(distances_from(roadmap, cells[:ALONE])[:, cells].mean())
