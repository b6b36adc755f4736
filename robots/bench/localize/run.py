"""One run in the simulated world: drive, localize beside it, and compare with where the robot really is."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.build import build_layers
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridMap
from robots.bench.localize.localizer import Localizer
from robots.bench.localize.route import Route
from robots.sim.robot import SimulatedRobot
from robots.sim.world import World

ODOM_STEPS, SCAN_STEPS = 3, 5
"""Steps of the world (20 ms) between two messages: odometry at 17 Hz, scans at 10 Hz."""

LOST, LOST_TURN = 0.5, math.radians(20.0)
"""A robot that is told to be farther off than this is lost [m, rad]."""

BEFORE = 10.0
"""A robot is carried off after this way [m]."""

CERTAIN = 2.0
"""A robot is found where it is lost no more to the end of its way, and that is at least so far [m]."""

Kind = Literal["track", "kidnap", "global"]


@dataclass(frozen=True, slots=True)
class Job:
    """What to run.

    Parameters
    ----------
    grid : GridMap
    kind : {"track", "kidnap", "global"}
        The robot is told where it starts; is told so, and carried off later; is not told.
    metres : float
        To drive; after it was carried off, or from the start [m].
    parameters : dict
        Of amcl.
    seed, run : int
        What is left to chance depends on these and the kind, and nothing else.
    """

    grid: GridMap
    kind: Kind
    metres: float
    parameters: dict[str, Any]
    seed: int
    run: int


@dataclass(frozen=True, slots=True)
class Result:
    """What came of a run; errors are taken at each scan, once the robot is found.

    Parameters
    ----------
    error, turn_error : float
        Mean [m, rad].
    worst, worst_turn : float
        Largest [m, rad].
    lost : bool
        It was lost when it should not have been, or was not found.
    found : float or None
        After which way it was found [m]; 0 where it never was to be looked for.
    metres : float
        Way driven [m].
    update : float
        Mean time that a scan took [s].
    """

    run: int
    error: float
    turn_error: float
    worst: float
    worst_turn: float
    lost: bool
    found: float | None
    metres: float
    update: float


def drive(job: Job) -> Result:
    """Drive one run, faster than real time."""
    seed = np.random.default_rng((job.seed, job.run, len(job.kind)))
    route = Route(job.grid, seed)
    start = route.anywhere()
    world = World(job.grid, int(seed.integers(1 << 30)))
    robot = world.add_robot(start)
    parameters = {"seed": job.run, **job.parameters}
    told = start if job.kind != "global" else route.anywhere()
    localizer = Localizer(build_layers(job.grid), told, parameters)
    route.begin(start)
    if job.kind == "global":
        localizer.look_everywhere()
    elif job.kind == "kidnap":
        for _ in _errors(world, robot, route, localizer, BEFORE):
            pass
        there = route.anywhere()
        robot.base.carry_to(there)
        route.begin(there)
    begin = robot.base.travelled
    rows = list(_errors(world, robot, route, localizer, begin + job.metres))
    return _judge(job, np.array(rows), begin, float(np.mean(localizer.seconds)))


def _errors(
    world: World, robot: SimulatedRobot, route: Route, localizer: Localizer, metres: float
) -> Iterator[tuple[float, float, float]]:
    """Drive on until so many metres; give way [m], error [m] and turn [rad] at each scan."""
    while robot.base.travelled < metres:
        if world.steps % ODOM_STEPS == 0 or world.steps % SCAN_STEPS == 0:
            localizer.odometry(robot.odometry())
        if world.steps % SCAN_STEPS == 0:
            robot.command(route.steer(robot.base.pose))
            pose = localizer.scan(robot.scan())
            if pose is not None:
                yield (robot.base.travelled, *_apart(pose, robot.base.pose))
        world.step()


def _apart(told: Pose2D, true: Pose2D) -> tuple[float, float]:
    return told.distance_to(true), abs(wrap_angle(told.theta - true.theta))


def found_after(way: NDArray[np.float64], fine: NDArray[np.bool_]) -> float | None:
    """Return from where on all is fine [m], or None where less than `CERTAIN` metres are left from there.

    Parameters
    ----------
    way : (n,) array
        Ascending [m].
    fine : (n,) bool array
    """
    first = held_from(fine)
    return float(way[first]) if first < len(way) and way[-1] - way[first] >= CERTAIN else None


def held_from(fine: NDArray[np.bool_]) -> int:
    """Return from which scan on all is fine."""
    wrong = np.flatnonzero(~fine)
    return int(wrong[-1]) + 1 if len(wrong) else 0


def _judge(job: Job, rows: NDArray[np.float64], begin: float, seconds: float) -> Result:
    way, error, turn = rows.T
    way = way - begin
    fine = (error <= LOST) & (turn <= LOST_TURN)
    found = 0.0 if job.kind == "track" else found_after(way, fine)
    if found is None:
        return Result(job.run, math.nan, math.nan, math.nan, math.nan, True, None, float(way[-1]), seconds)
    # The way alone would not do: a robot that turns in place goes none.
    since = 0 if job.kind == "track" else held_from(fine)
    error, turn = error[since:], turn[since:]
    lost = job.kind == "track" and not bool(fine.all())
    return Result(
        job.run, float(error.mean()), float(turn.mean()), float(error.max()), float(turn.max()), lost, found,
        float(way[-1]), seconds,
    )  # fmt: skip
