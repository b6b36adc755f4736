"""Drives a Turtlebot through a map by each local planner, and times what the planner alone does in every cycle.

The base does at once what it is told: what is compared is the time that planners take at the same places, not how well
they drive, which ``ppaas bench barn`` tells.
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
"""Of a Turtlebot [m]."""

OUTLINE = ((0.15, 0.12), (-0.15, 0.12), (-0.15, -0.12), (0.15, -0.12))
"""Corners of a robot that is no disc [m]."""

WINDOW = 120
"""Cells along an edge of the local costmap: 6 m at 5 cm."""

RATE = 20.0
MOST = 60.0
"""Seconds after which a goal is let be: not to arrive is told, and is no reason to wait."""


@dataclass(frozen=True)
class Setup:
    """A local planner as it is measured.

    Parameters
    ----------
    name : str
        That it is told by.
    planner : str
        Of ``ppaas.controllers``.
    parameters : dict
        Other than its own defaults.
    limit : float
        What its cycles should not go beyond [ms].
    limited : str
        What of them: ``p99_ms``, or ``median_ms`` where others' figure is one for a cycle as any.
    """

    name: str
    planner: str
    parameters: dict[str, Any] = field(default_factory=dict)
    limit: float = 10.0
    limited: Literal["p99_ms", "median_ms"] = "p99_ms"


@dataclass
class Cycles:
    """What came of driving by a local planner.

    Parameters
    ----------
    setup : Setup
    seconds : list of float
        That each cycle took.
    goals, arrived : int
        How many it was sent to, and how many of them it came to.
    """

    setup: Setup
    seconds: list[float] = field(default_factory=list)
    goals: int = 0
    arrived: int = 0


def setups(names: tuple[str, ...] = ()) -> list[Setup]:
    """Return all local planners with their defaults, or those that are named; ``dwa`` also as ROS is measured.

    Raises
    ------
    NotFound
        There is no such local planner.
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
    """ControlledDrive by each in turn to the same goals, one goal after the other.

    Parameters
    ----------
    grid : GridMap
    chosen : list of Setup
    goals : int
        To be driven to, by each.
    seed : int
        The same seed chooses the same goals.
    threads : int
        Most threads of a planner.
    clock : callable
        Returns seconds.
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
                drive.go(_made(cycles.setup), clock, until=1.0)  # kernels are loaded, and caches are warm
                drive = ControlledDrive(costmap, start, plan, threads)
            cycles.seconds += drive.go(_made(cycles.setup), clock)
            cycles.goals, cycles.arrived = cycles.goals + 1, cycles.arrived + drive.arrived
            done()
    return told


def _made(setup: Setup) -> Controller:
    return create(setup.planner, robot_radius=RADIUS, **setup.parameters)


class ControlledDrive:
    """One drive along a plan.

    Parameters
    ----------
    costmap : Costmap
        Of the whole map.
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
        """ControlledDrive to the end; return what each cycle took [s]."""
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
    """Return the costmap around a robot: ``WINDOW`` cells along each edge, unknown where the map ends."""
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
    """Return a row for each: how many cycles, their median, 99th percentile and longest [ms].

    Raises
    ------
    PPaaSError
        One had not a single cycle.
    """
    rows = []
    for cycles in told:
        if not cycles.seconds:
            raise PPaaSError(f"{cycles.setup.name} stood at each goal before its first cycle: choose another --seed")
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
