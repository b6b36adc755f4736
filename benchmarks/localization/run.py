"""Runs in the simulated world: a robot drives and localizes, and the estimates are compared with the true poses."""

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.parallel_runs import run_all
from benchmarks.localization.crowd import Crowd, CrowdedWorld, Inching
from benchmarks.localization.localizer import Localizer
from benchmarks.localization.route import RandomRoute
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Twist
from robots.sim.shortest_paths import ShortestPaths

ODOM_STEPS, SCAN_STEPS = 3, 5
"""Steps of the world (20 ms) between two messages: odometry at 17 Hz, scans at 10 Hz."""

Errors = Iterator[tuple[float, float, float]]
"""Driven distance [m] and errors of localization [m, rad] at each scan."""


class LocalizationScene:
    """A robot at a random pose of a map.

    Parameters
    ----------
    grid : GridMap
    parameters : dict
        Parameters of amcl.
    rng : numpy.random.Generator
        Random source of the start, the route and the people.
    told : bool
        Whether localization gets the initial pose.

    Attributes
    ----------
    localizer : Localizer
    """

    def __init__(self, grid: GridMap, parameters: dict[str, Any], rng: np.random.Generator, *, told: bool) -> None:
        self._rng = rng
        self._route = RandomRoute(grid, rng)
        start = self._route.anywhere()
        self._world = CrowdedWorld(grid, int(rng.integers(1 << 30)))
        self._robot = self._world.add_robot(start)
        self.localizer = Localizer(build_layers(grid), start if told else self._route.anywhere(), parameters)
        self._route.begin(start)
        if not told:
            self.localizer.look_everywhere()

    @property
    def way(self) -> float:
        """Driven distance [m]."""
        return self._robot.base.travelled

    def drive(self, metres: float) -> Errors:
        """Drive a distance [m]; yield the errors at each scan."""
        end = self.way + metres
        return self._errors(self._route.steer, lambda: self.way >= end)

    def jam(self, people: int, seconds: float) -> Errors:
        """Crowd the robot with people for a time [s]; yield the errors at each scan."""
        world, rng = self._world, self._rng
        world.crowd = Crowd(self._robot, ShortestPaths(world.grid, world.pedestrian_model.clearance, rng), people, rng)
        end = world.time() + seconds
        yield from self._errors(Inching(self._route, world, rng).steer, lambda: world.time() >= end)
        world.crowd = None

    def stand(self, seconds: float) -> Errors:
        """Leave the robot where it is for a time [s]; yield the errors at each scan."""
        end = self._world.time() + seconds
        return self._errors(lambda _: Twist(), lambda: self._world.time() >= end)

    def creep(self, seconds: float) -> Errors:
        """Drive very slowly for a time [s]; yield the errors at each scan."""
        end = self._world.time() + seconds
        return self._errors(self._route.creep, lambda: self._world.time() >= end)

    def carry_off(self) -> None:
        """Kidnap the robot: move it to a random pose without odometry."""
        there = self._route.anywhere()
        self._robot.base.carry_to(there)
        self._route.begin(there)

    def _errors(self, steer: Callable[[Pose2D], Twist], ended: Callable[[], bool]) -> Errors:
        world, robot = self._world, self._robot
        while not ended():
            if world.steps % ODOM_STEPS == 0 or world.steps % SCAN_STEPS == 0:
                self.localizer.odometry(robot.odometry())
            if world.steps % SCAN_STEPS == 0:
                true = robot.base.pose
                robot.command(steer(true))
                told = self.localizer.scan(robot.scan())
                if told is not None:
                    yield self.way, told.distance_to(true), abs(wrap_angle(told.theta - true.theta))
            world.step()


LOST, LOST_TURN = 0.5, math.radians(20.0)
"""Errors of the estimate above which a robot is lost [m, rad]."""

BEFORE = 10.0
"""Distance that a robot drives before it is kidnapped or crowded, stands or creeps [m]."""

JAM = 80.0
"""Time for which people crowd around the robot [s]."""

CERTAIN = 2.0
"""Smallest distance to the end of a run without a lost scan, for a robot to count as found [m]."""

Kind = Literal["track", "kidnap", "global", "jam", "stand", "creep"]


@dataclass(frozen=True, slots=True)
class LocalizationJob:
    """Settings of a run.

    Parameters
    ----------
    grid : GridMap
    kind : {"track", "kidnap", "global", "jam", "stand", "creep"}
        ``track``: the initial pose is known. ``kidnap``: it is known, and the robot is moved elsewhere later.
        ``global``: it is unknown. ``jam``: it is known, and people crowd around the robot later. ``stand`` and
        ``creep``: it is known, and after some metres the robot stands still, or drives very slowly, for a time.
    metres : float
        Distance to drive, from the start, the kidnapping or the end of the crowding [m].
    parameters : dict
        Parameters of amcl.
    seed, run : int
        All randomness depends on these and the kind alone.
    people : int
        Number of people in the crowd.
    minutes : float
        Time for which the robot stands or creeps [min].
    """

    grid: GridMap
    kind: Kind
    metres: float
    parameters: dict[str, Any]
    seed: int
    run: int
    people: int = 0
    minutes: float = 0.0


@dataclass(frozen=True, slots=True)
class LocalizationResult:
    """Result of a run; errors are those of all scans, or of those after the robot was found.

    Parameters
    ----------
    error, turn_error : float
        Mean errors [m, rad].
    worst, worst_turn : float
        Largest errors [m, rad].
    lost : bool
        Whether the robot was lost although its pose was known, or was not found.
    found : float or None
        Distance after which the robot was found [m]; 0 if its pose was known.
    metres : float
        Driven distance [m].
    update : float
        Mean time to process a scan [s].
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


def drive(job: LocalizationJob) -> LocalizationResult:
    """Simulate a run, faster than real time."""
    rng = np.random.default_rng((job.seed, job.run, len(job.kind)))
    scene = LocalizationScene(job.grid, {"seed": job.run, **job.parameters}, rng, told=job.kind != "global")
    if job.kind in ("kidnap", "jam", "stand", "creep"):
        deque(scene.drive(BEFORE), maxlen=0)
        scene.localizer.seconds.clear()
    if job.kind == "kidnap":
        scene.carry_off()
    begin = scene.way
    rows = list(_errors(job, scene))
    return _judge(job, np.array(rows), begin, float(np.mean(scene.localizer.seconds)))


def _errors(job: LocalizationJob, scene: LocalizationScene) -> Errors:
    if job.kind == "stand":
        return scene.stand(60.0 * job.minutes)
    if job.kind == "creep":
        return scene.creep(60.0 * job.minutes)
    crowded = scene.jam(job.people, JAM) if job.kind == "jam" else iter(())
    return chain(crowded, scene.drive(job.metres))


def found_after(way: NDArray[np.float64], fine: NDArray[np.bool_]) -> float | None:
    """Return the distance from which all scans are fine [m]; None if less than `CERTAIN` metres are left then.

    Parameters
    ----------
    way : (n,) array
        Driven distance at each scan, ascending [m].
    fine : (n,) bool array
        Whether the errors of each scan are small.
    """
    first = held_from(fine)
    return float(way[first]) if first < len(way) and way[-1] - way[first] >= CERTAIN else None


def held_from(fine: NDArray[np.bool_]) -> int:
    """Return the index of the first scan from which all scans are fine."""
    wrong = np.flatnonzero(~fine)
    return int(wrong[-1]) + 1 if len(wrong) else 0


def _judge(job: LocalizationJob, rows: NDArray[np.float64], begin: float, seconds: float) -> LocalizationResult:
    way, error, turn = rows.T
    way = way - begin
    fine = (error <= LOST) & (turn <= LOST_TURN)
    known = job.kind not in ("kidnap", "global")
    found = 0.0 if known else found_after(way, fine)
    if found is None:
        return LocalizationResult(job.run, math.nan, math.nan, math.nan, math.nan, True, None, float(way[-1]), seconds)
    # By scan, not by distance: a robot that turns in place drives no distance.
    since = 0 if known else held_from(fine)
    error, turn = error[since:], turn[since:]
    lost = known and not bool(fine.all())
    return LocalizationResult(
        job.run, float(error.mean()), float(turn.mean()), float(error.max()), float(turn.max()), lost, found,
        float(way[-1]), seconds,
    )  # fmt: skip


# -- all runs of the localization bench, in parallel processes, and their summary --------------------------------------

WITHIN = 10.0
"""Distance within which a robot should be found [m]."""


def measure(jobs: Sequence[LocalizationJob], processes: int, done: Callable[[], None]) -> list[LocalizationResult]:
    """Simulate all runs; return the results in the order of the jobs. ``done`` is called after each run."""
    return run_all(drive, jobs, processes, done)


def summary(results: Sequence[LocalizationResult]) -> dict[str, Any]:
    """Return the summary of all runs; its errors leave out lost runs, and are null if all runs were lost."""
    held = [result for result in results if not result.lost]
    ways = [result.found for result in results]
    found = [way for way in ways if way is not None]
    return {
        "runs": len(results),
        "metres": round(sum(result.metres for result in results), 1),
        "error_cm": _mean([100.0 * result.error for result in held]),
        "error_deg": _mean([math.degrees(result.turn_error) for result in held]),
        "worst_cm": round(100.0 * max((result.worst for result in held), default=0.0), 1) if held else None,
        "worst_deg": round(math.degrees(max(result.worst_turn for result in held)), 1) if held else None,
        "lost": sum(result.lost for result in results),
        "found_within_10_m": round(sum(way <= WITHIN for way in found) / len(results), 3),
        "median_found_m": round(float(np.median(found)), 2) if found else None,
        "update_ms": _mean([1e3 * result.update for result in results]),
    }


def _mean(values: Sequence[float]) -> float | None:
    return round(float(np.mean(values)), 3) if values else None
