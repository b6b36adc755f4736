"""Bench of control cycles: drives a Turtlebot by each local planner, and times the planner in each cycle.

The simulated base follows commands exactly. The bench compares the computing times of planners on the same goals;
``ppaas bench barn`` compares how well they drive.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ppaas.clock import Clock, monotonic
from ppaas.controllers.base import Controller, ControlRequest, NoValidControl, Velocity
from ppaas.controllers.motion import advance
from ppaas.controllers.registry import CONTROLLERS, controller_names, create
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import NO_INFORMATION, Costmap
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D, Poses
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.planners.base import PlanRequest
from ppaas.planners.registry import create as create_planner
from robots.sim.courses import CoursePlanner

RADIUS = 0.18
"""Radius of a Turtlebot [m]."""

OUTLINE = ((0.15, 0.12), (-0.15, 0.12), (-0.15, -0.12), (0.15, -0.12))
"""Corners of a polygonal footprint [m]."""

WINDOW = 120
"""Edge of the local costmap [cells]: 6 m at 5 cm."""

RATE = 20.0
"""Control frequency [Hz]."""
MOST = 60.0
"""Time limit of a goal in simulated time [s]; the summary counts the goals that were reached."""


@dataclass(frozen=True)
class Setup:
    """A local planner and its settings.

    Parameters
    ----------
    name : str
        Name in the results.
    planner : str
        Name of the plug-in, as in ``ppaas.controllers``.
    parameters : dict
        Parameters that differ from the defaults.
    limit : float
        Largest acceptable time of a cycle [ms].
    limited : str
        Statistic that the limit applies to: ``p99_ms``, or ``median_ms`` if the published figure is typical.
    """

    name: str
    planner: str
    parameters: dict[str, Any] = field(default_factory=dict)
    limit: float = 10.0
    limited: Literal["p99_ms", "median_ms"] = "p99_ms"


@dataclass
class Cycles:
    """Results of a local planner.

    Parameters
    ----------
    setup : Setup
    seconds : list of float
        Time of each cycle [s].
    goals, arrived : int
        Number of goals, and of goals that were reached.
    """

    setup: Setup
    seconds: list[float] = field(default_factory=list)
    goals: int = 0
    arrived: int = 0


def setups(names: tuple[str, ...] = ()) -> list[Setup]:
    """Return the named local planners, or all, with default settings; ``dwa`` also with settings published for ROS.

    Raises
    ------
    NotFound
        There is no local planner of that name.
    """
    chosen = [CONTROLLERS.own_name(name) for name in names] or list(controller_names())
    for name in chosen:
        CONTROLLERS.load(name)
    found = [Setup(name, name) for name in chosen]
    if "dwa" in chosen:
        samples = {"vx_samples": 20, "vth_samples": 20, "sim_time": 1.7, "footprint": OUTLINE}
        found.append(Setup("dwa, 20 by 20, polygon, 1.7 s", "dwa", samples, 1.0, "median_ms"))
    return found


def measure(
    grid: GridMap,
    chosen: list[Setup],
    goals: int,
    *,
    seed: int = 0,
    threads: int = 1,
    clock: Clock = monotonic,
    done: Callable[[], object] = lambda: None,
) -> list[Cycles]:
    """Drive to the same goals by each local planner.

    Parameters
    ----------
    grid : GridMap
    chosen : list of Setup
    goals : int
        Number of goals for each local planner.
    seed : int
        Seed of the goals.
    threads : int
        Largest number of threads of a planner.
    clock : callable
        Clock of the measured times [s].
    done : callable
        Called after each drive.
    """
    [course] = CoursePlanner(grid, seed).choose(1, goals)
    costmap = build_layers(grid, robot_radius=RADIUS).costmap
    told = [Cycles(setup) for setup in chosen]
    for start, goal in zip((course.start, *course.goals), course.goals, strict=False):
        plan = create_planner("dijkstra").plan(costmap, PlanRequest(start, goal)).poses
        for cycles in told:
            drive = ControlledDrive(costmap, start, plan, threads)
            if not cycles.goals:
                drive.go(_made(cycles.setup), clock, until=1.0)  # warm-up: loads kernels and fills caches
                drive = ControlledDrive(costmap, start, plan, threads)
            cycles.seconds += drive.go(_made(cycles.setup), clock)
            cycles.goals, cycles.arrived = cycles.goals + 1, cycles.arrived + drive.arrived
            done()
    return told


def _made(setup: Setup) -> Controller:
    return create(setup.planner, robot_radius=RADIUS, **setup.parameters)


class ControlledDrive:
    """A drive along a plan, in which the base follows commands exactly.

    Parameters
    ----------
    costmap : Costmap
        Costmap of the whole map.
    start : Pose2D
    plan : (n, 7) array
    threads : int
    """

    def __init__(self, costmap: Costmap, start: Pose2D, plan: Poses, threads: int) -> None:
        self._costmap = costmap
        self._start = start
        self._plan = plan
        self._threads = threads
        self.arrived = False

    def go(self, controller: Controller, clock: Clock, until: float = MOST) -> list[float]:
        """Drive to the goal, or for ``until`` seconds of simulated time; return the time of each cycle [s]."""
        controller.set_plan(self._plan)
        return list(self._cycles(controller, clock, round(until * RATE)))

    def _cycles(self, controller: Controller, clock: Clock, most: int) -> Iterator[float]:
        pose, velocity = self._start, Velocity()
        for _ in range(most):
            if controller.is_goal_reached(pose, velocity):
                self.arrived = True
                return
            request = ControlRequest(pose, velocity, window(self._costmap, pose), 1.0 / RATE, self._threads)
            began = clock()
            try:
                velocity = controller.compute_velocity(request)
            except NoValidControl:
                velocity = Velocity()
            yield clock() - began
            pose = advance(pose, velocity, 1.0 / RATE)


def window(costmap: Costmap, pose: Pose2D) -> Costmap:
    """Return the costmap around a robot: ``WINDOW`` by ``WINDOW`` cells, unknown outside the map."""
    info = costmap.info
    row, column = (int(cell) - WINDOW // 2 for cell in info.to_cells((pose.x, pose.y)))
    seen: NDArray[np.uint8] = np.full((WINDOW, WINDOW), NO_INFORMATION, np.uint8)
    rows, columns = (
        np.clip((first, first + WINDOW), 0, size) for first, size in ((row, info.height), (column, info.width))
    )
    seen[rows[0] - row : rows[1] - row, columns[0] - column : columns[1] - column] = costmap.data[
        slice(*rows), slice(*columns)
    ]
    corner = info.origin @ Pose2D(column * info.resolution, row * info.resolution)
    return Costmap(seen, GridInfo(info.resolution, WINDOW, WINDOW, corner))


def summary(told: list[Cycles]) -> list[dict[str, Any]]:
    """Return a row for each local planner: number of cycles, and their median, 99th percentile and maximum [ms].

    Raises
    ------
    PPaaSError
        A local planner ran no cycle.
    """
    rows = []
    for cycles in told:
        if not cycles.seconds:
            raise PPaaSError(
                f"{cycles.setup.name} started at each of its goals and ran no cycle: choose another --seed"
            )
        median, most, longest = (
            round(float(part), 3) for part in 1e3 * np.percentile(cycles.seconds, (50.0, 99.0, 100.0))
        )
        rows.append({
            "planner": cycles.setup.name, "cycles": len(cycles.seconds),
            "median_ms": median, "p99_ms": most, "longest_ms": longest,
            "limit": f"{cycles.setup.limited} ≤ {cycles.setup.limit:g}",
            "arrived": cycles.arrived, "goals": cycles.goals,
        })  # fmt: skip
    return rows
