"""Part ``coordinator``: cycles of the coordinator with many robots and people, beside a plan for each pair of both."""

import gc
from dataclasses import dataclass
from time import thread_time

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.figures import Figure, PartResult
from benchmarks.people.options import PeopleOptions
from benchmarks.people.report_world import AROUND, VIEW, ReportingRobot, ReportWorld
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.generate import warehouse
from ppaas.people.coordinator.coordinator import PeopleCoordinator
from ppaas.people.settings import PeopleSettings
from ppaas.people.tracks.assignment import solver
from ppaas.planners.base import PlanRequest
from ppaas.planners.batch.plan_many import plan_many
from ppaas.planners.grid.dijkstra import Dijkstra

Array = NDArray[np.float64]

PART = "coordinator"
PERIOD = 0.2
"""Time between two cycles [s]."""
NOW = 1_700_000_000.0
GROUPS = ((2, 20), (10, 50), (50, 200))
"""Numbers of robots and of people; the last group has the bar."""
CYCLES, QUICK, FIRST = 600, 60, 25
"""Cycles of a run, of a quick run, and those that are not counted: robots and people meet."""
LONGEST = 10.0
"""Largest 99th percentile of a cycle [ms]."""
PAIRS = 10
"""Pairs of robot and person for which the baseline plans."""


@dataclass(frozen=True, slots=True)
class Run:
    """CPU times of one run [s]: other processes may share the cores.

    Parameters
    ----------
    cycles, reports, checkpoints : array
        Each cycle, the reports of each cycle together, and checkpoints.
    plan : float
        A plan from a robot to a person whom it sees, as the mean of some.
    pairs : float
        Mean number of pairs of a robot and a person whom it sees.
    counted, orders : float
        Mean count, and mean number of orders.
    """

    robots: int
    people: int
    cycles: Array
    reports: Array
    checkpoints: Array
    plan: float
    pairs: float
    counted: float
    orders: float


def measure(options: PeopleOptions) -> PartResult:
    """Return the times of cycles with the groups of `GROUPS` on a warehouse of 60 m × 40 m.

    The garbage collector leaves out the loaded modules, as in a container. Scipy is loaded before the first cycle; a
    container loads it in another thread.
    """
    costmap = build_layers(warehouse(options.seed, 60.0, 40.0)).costmap
    solver()
    gc.freeze()
    try:
        runs = [_run(costmap, *group, options) for group in GROUPS]
    finally:
        gc.unfreeze()
    return PartResult(
        [figure for run in runs for figure in _figures(run)],
        [_row(run) for run in runs],
        [{"robots": run.robots, "people": run.people, "cycle_p99_ms": 1e3 * _p99(run.cycles)} for run in runs],
    )


def _run(costmap: Costmap, robots: int, people: int, options: PeopleOptions) -> Run:
    """Return the times of a run. Every second robot has a camera, the others a laser that turns."""
    world = ReportWorld(costmap, people, _robots(costmap, robots, options.seed), options.seed)
    coordinator = PeopleCoordinator(costmap, PeopleSettings(followed_at_once=max(1, robots // 5), history=True))
    cycles, reports, checkpoints, pairs, counts, orders = [], [], [], [], [], []
    for cycle in range(FIRST + (QUICK if options.quick else CYCLES)):
        now = NOW + cycle * PERIOD
        world.advance(PERIOD)
        messages = [world.report(robot, now) for robot in world.robots]
        began = thread_time()
        for message in messages:
            coordinator.report(message, now)
        reported = thread_time()
        state = coordinator.step(now)
        cycled = thread_time()
        coordinator.checkpoint()
        if cycle >= FIRST:
            cycles.append(cycled - reported)
            reports.append(reported - began)
            checkpoints.append(thread_time() - cycled)
            pairs.append(sum(len(message.people) for message in messages))
            counts.append(state.count)
            orders.append(len(state.orders))
    return Run(
        robots, people, np.array(cycles), np.array(reports), np.array(checkpoints), _plan(costmap, world),
        float(np.mean(pairs)), float(np.mean(counts)), float(np.mean(orders)),
    )  # fmt: skip


def _robots(costmap: Costmap, count: int, seed: int) -> list[ReportingRobot]:
    random = np.random.default_rng(seed)
    free = costmap.info.to_world(np.argwhere(costmap.data == 0))
    places = free[random.integers(len(free), size=count)].tolist()
    return [
        ReportingRobot(
            f"r{number}", Pose2D(x, y, random.uniform(-3.0, 3.0)), view=(VIEW, AROUND)[number % 2],
            turns=random.uniform(-0.5, 0.5), deviation=random.uniform(0.03, 0.15),
        )
        for number, (x, y) in enumerate(places)
    ]  # fmt: skip


def _plan(costmap: Costmap, world: ReportWorld) -> float:
    """Return the mean time of a plan from a robot to a person whom it sees [s]."""
    requests = [
        PlanRequest(robot.pose, Pose2D(*world.people[person].tolist()), tolerance=1.0)
        for robot in world.robots
        for person in world.seen_by(robot)
    ][:PAIRS]
    plan_many(Dijkstra(), costmap, requests[:1])
    began = thread_time()
    plan_many(Dijkstra(), costmap, requests)
    return (thread_time() - began) / max(len(requests), 1)


def _p99(samples: Array) -> float:
    return float(np.percentile(samples, 99.0))


def _figures(run: Run) -> list[Figure]:
    group = f"{run.robots} robots, {run.people} people"
    last = (run.robots, run.people) == GROUPS[-1]
    low, high = 1e3 * float(run.cycles.min()), 1e3 * float(run.cycles.max())
    figures = [
        Figure(PART, f"{group}: cycle, p99", round(1e3 * _p99(run.cycles), 2), "ms", round(low, 2), round(high, 2),
               LONGEST if last else None, note=f"{len(run.cycles)} cycles"),
    ]  # fmt: skip
    if last:
        figures.append(
            Figure(PART, f"{group}: a plan for each pair", round(1e3 * run.pairs * run.plan, 1), "ms", yardstick=True,
                   note=f"Dijkstra's planner, {run.pairs:.0f} pairs of a robot and a person whom it sees")
        )  # fmt: skip
    return figures


def _row(run: Run) -> dict[str, str]:
    def times(samples: Array) -> str:
        return f"{1e3 * float(np.median(samples)):.2f} ms"

    return {
        "robots": str(run.robots), "people": str(run.people), "pairs": f"{run.pairs:.0f}",
        "count": f"{run.counted:.1f}", "orders": f"{run.orders:.1f}", "cycle": times(run.cycles),
        "p99": f"{1e3 * _p99(run.cycles):.2f} ms", "reports": times(run.reports),
        "checkpoint": times(run.checkpoints),
    }  # fmt: skip
