"""Plans for the fleets of the MovingAI benchmarks, without a cloud."""

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from ppaas.errors import InvalidInput
from ppaas.fleet.first_plan import first_plan
from ppaas.fleet.improvement import Improvement, improved
from ppaas.fleet.kernels import distances, guides, lacam, neighbourhood, pibt, turns
from ppaas.fleet.plan import FleetPlan, turns_of
from ppaas.fleet.problem import FleetProblem
from ppaas.fleet.roadmap import Roadmap
from ppaas.maps.formats.movingai import parse_map, parse_scenario
from ppaas.maps.grid import FREE

KERNELS = (distances, guides, pibt, lacam, neighbourhood, turns)
"""Modules of the kernels that plans are made with."""

Tell = Callable[[str, float], None]
"""Receives what is being done, and the part of the time that has passed."""


def read_problem(map_file: Path, scenario_file: Path, agents: int | None) -> FleetProblem:
    """Return the problem of the first agents of a scenario, or of all for None.

    Raises
    ------
    InvalidInput, NoValidPath
        A file cannot be read, it has fewer agents, or an agent cannot reach its goal.
    """
    roadmap = Roadmap.of_grid(parse_map(_read(map_file)).data == FREE)
    scenario = parse_scenario(_read(scenario_file))
    if agents is not None and agents > len(scenario):
        raise InvalidInput(f"{scenario_file.name} has {len(scenario)} agents, not {agents}")
    chosen = scenario.first(agents)
    return FleetProblem.of(roadmap, chosen.starts, chosen.goals)


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InvalidInput(f"cannot read {path}: {error.strerror}") from error


def answer_of(
    read: Callable[[], FleetProblem], seconds: float, *, threads: int, seed: int, turn: float | None, tell: Tell
) -> dict[str, Any]:
    """Plan for a fleet, and improve the plan for the rest of a time.

    The kernels are loaded before, which does not count: it takes as long for each problem, and minutes where they were
    never compiled.

    Parameters
    ----------
    read : callable
        Returns the problem; its time counts.
    seconds : float
        CPU time of all threads [s]; the first plan is not interrupted by it.
    threads : int
        Number of threads that improve the plan, each with its own random numbers; the best plan is kept.
    seed : int
        Seed of the random numbers.
    turn : float, optional
        Cost of a quarter turn when the plan is improved [steps]; the answer has the number of turns then.
    tell : callable
        Receives the progress.
    """
    tell("loading", 0.0)
    for kernels in KERNELS:
        kernels.warm()
    began = time.process_time()
    tell("first plan", 0.0)
    problem = read()
    first = first_plan(problem, seed)
    spent = time.process_time() - began

    def passed() -> float:
        part = (time.process_time() - began) / seconds
        tell("improving", min(part, 1.0))
        return part

    def improve(number: int) -> Improvement:
        return improved(problem, first, seed + number, turn or 0.0, passed)

    best = _best_of(improve, threads) if spent < seconds else first
    return {
        "agents": len(problem),
        "cost": best.cost,
        "bound": problem.bound,
        "makespan": best.makespan,
        "first": {"cpu_seconds": round(spent, 3), "cost": first.cost},
        "cpu_seconds": round(time.process_time() - began, 3),
        **({} if turn is None else {"turns": int(turns_of(problem.roadmap, best).sum())}),
        "paths": _paths(problem, best),
    }


def _best_of(improve: Callable[[int], Improvement], threads: int) -> FleetPlan:
    with ThreadPoolExecutor(threads) as pool:
        return min(pool.map(improve, range(threads)), key=lambda found: found.cost).plan()


def _paths(problem: FleetProblem, plan: FleetPlan) -> list[list[list[int]]]:
    places = problem.roadmap.cells[plan.steps]
    paths: list[list[list[int]]] = np.swapaxes(places, 0, 1).tolist()
    return paths
