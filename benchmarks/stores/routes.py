"""Daily routes of a fleet in a warehouse, computed by a planner: the data of the plan store bench.

Each robot visits the same stations every day. At a station it stops in one of a few cells, at which its next route
begins, so routes between the same stations differ at their ends and coincide in between.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.errors import PlanningError
from ppaas.geometry import Pose2D
from ppaas.maps.generate import warehouse
from ppaas.planners.base import PlanRequest
from ppaas.planners.batch.plan_many import plan_many
from ppaas.planners.grid.dijkstra import Dijkstra
from ppaas.planners.path import path_poses
from ppaas.planners.smoothing import smooth_path
from ppaas.plans.passages import length_between
from storage.records import PlanRecord

if TYPE_CHECKING:
    from rich.progress import Progress

MAP, VERSION, USER = "bench-warehouse", "bench", "bench"
WIDTH, HEIGHT = 36.0, 22.0
STATIONS, ROBOTS, ROUND = 120, 50, 12
STOPS = [(row, column) for row in (-1, 0, 1) for column in (-1, 0, 1)]
"""Offsets from a station to the cells in which robots stop."""
YAWS = (0.0, 1.5708, 3.1416, -1.5708)
MEAN_TIME = 7.3
"""Time between two plans of the fleet [s]."""

Stop = tuple[int, int]


@dataclass(frozen=True)
class Routes:
    """Plans of a fleet in order of time, and the distinct routes that they use.

    Parameters
    ----------
    costmap : Costmap
    drawn : (n,) array
        Index of the route of each plan.
    robots : (n,) array
        Number of the robot of each plan.
    cells, stops : (k, 2) array, (m,) array
        Cells (row, column) of all routes in sequence, and the end of each route in ``cells``.
    told : (m, 3) array
        Cost, length [m] and planning time [s] of each route.
    """

    costmap: Costmap
    drawn: NDArray[np.int32]
    robots: NDArray[np.int16]
    cells: NDArray[np.int16]
    stops: NDArray[np.int64]
    told: NDArray[np.float64]

    def records(self, first: int, last: int, *, smooth: bool = False) -> Iterator[PlanRecord]:
        """Yield the plans ``first`` to ``last - 1``, each with its own id."""
        for number in range(first, last):
            yield self.record(number, smooth=smooth)

    def record(self, number: int, *, smooth: bool = False) -> PlanRecord:
        """Return a plan by its number."""
        route = int(self.drawn[number])
        cells = self.cells[self.stops[route - 1] if route else 0 : self.stops[route]].astype(np.int32)
        start, goal = (self._pose(cells[end]) for end in (0, -1))
        poses = path_poses(self.costmap, cells, start, goal)
        cost, length, seconds = self.told[route].tolist()
        if smooth:
            poses = smooth_path(self.costmap, poses)
            length = length_between(poses[:, :2], 0, len(poses) - 1)
        return PlanRecord(
            id=np.random.default_rng(number).bytes(16).hex(), user=USER, map=MAP, version=VERSION, planner="dijkstra",
            start=(start.x, start.y, start.theta), goal=(goal.x, goal.y, goal.theta), length=length, cost=cost,
            seconds=seconds, poses=poses.tobytes(), created=1.8e9 + round(number * MEAN_TIME, 3),
            robot=f"robot{self.robots[number]}",
        )  # fmt: skip

    def _pose(self, cell: NDArray[np.int32]) -> Pose2D:
        x, y = self.costmap.info.to_world(cell).tolist()
        return Pose2D(round(x, 6), round(y, 6), YAWS[int(cell.sum()) // 3 % 4])


def routes(count: int, seed: int, folder: Path, progress: "Progress") -> Routes:
    """Return ``count`` plans of a fleet, from a file of an earlier run if there is one."""
    costmap = build_layers(warehouse(seed, WIDTH, HEIGHT)).costmap
    legs, drawn, robots = _driven(costmap, count, seed)
    file = folder / f"routes-{seed}-{count}.npz"
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        cells, stops, told = _planned(costmap, legs, progress)
        fresh = file.with_suffix(f".{os.getpid()}.npz")
        np.savez(fresh, cells=cells, stops=stops, told=told)
        fresh.replace(file)
    with np.load(file) as kept:
        return Routes(costmap, drawn, robots, kept["cells"], kept["stops"], kept["told"])


def _driven(
    costmap: Costmap, count: int, seed: int
) -> tuple[list[tuple[Stop, Stop]], NDArray[np.int32], NDArray[np.int16]]:
    """Return the distinct legs, and the leg and the robot of each plan."""
    random = np.random.default_rng(seed)
    stations = _stations(costmap, random)
    rounds = [random.choice(STATIONS, ROUND, replace=False) for _ in range(ROBOTS)]
    at = [_stop(stations[each[0]], random) for each in rounds]
    legs: dict[tuple[Stop, Stop], int] = {}
    drawn, robots = np.empty(count, np.int32), np.empty(count, np.int16)
    for number in range(count):
        robot, leg = number % ROBOTS, number // ROBOTS + 1
        goal = _stop(stations[rounds[robot][leg % ROUND]], random)
        drawn[number] = legs.setdefault((at[robot], goal), len(legs))
        at[robot], robots[number] = goal, robot
    return list(legs), drawn, robots


def _stations(costmap: Costmap, random: np.random.Generator) -> NDArray[np.int64]:
    """Return free cells away from obstacles, all reachable from the first."""
    free = np.argwhere(costmap.data == 0)
    chosen = free[random.choice(len(free), 4 * STATIONS, replace=False)]
    x, y = costmap.info.to_world(chosen[0]).tolist()
    requests = [PlanRequest(Pose2D(*costmap.info.to_world(cell).tolist()), Pose2D(x, y)) for cell in chosen]
    answers = plan_many(Dijkstra(), costmap, requests)
    return chosen[[not isinstance(answer, PlanningError) for answer in answers]][:STATIONS]


def _stop(station: NDArray[np.int64], random: np.random.Generator) -> Stop:
    row, column = STOPS[int(random.integers(len(STOPS)))]
    return int(station[0]) + row, int(station[1]) + column


def _planned(
    costmap: Costmap, legs: list[tuple[Stop, Stop]], progress: "Progress"
) -> tuple[NDArray[np.int16], NDArray[np.int64], NDArray[np.float64]]:
    task = progress.add_task("planning routes", total=len(legs))
    threads = len(os.sched_getaffinity(0))
    cells, told = [], []
    by_goal = sorted(range(len(legs)), key=lambda leg: legs[leg][1])
    found: dict[int, tuple[NDArray[np.int16], tuple[float, float, float]]] = {}
    for begin in range(0, len(by_goal), 4096):
        some = by_goal[begin : begin + 4096]
        ends = [[Pose2D(*costmap.info.to_world(cell).tolist()) for cell in legs[leg]] for leg in some]
        requests = [PlanRequest(start, goal) for start, goal in ends]
        for leg, answer in zip(some, plan_many(Dijkstra(), costmap, requests, threads=threads), strict=True):
            if isinstance(answer, PlanningError):
                raise answer
            found[leg] = answer.cells.astype(np.int16), (answer.cost, answer.length, round(answer.seconds, 6))
        progress.advance(task, len(some))
    for leg in range(len(legs)):
        cells.append(found[leg][0])
        told.append(found[leg][1])
    progress.remove_task(task)
    return np.concatenate(cells), np.cumsum([len(each) for each in cells]), np.array(told)
