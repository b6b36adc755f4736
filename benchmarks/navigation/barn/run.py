"""BARN runs: the robot drives until it arrives, collides, or exceeds the time limit; their scores and summary."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from benchmarks.harness.parallel_runs import run_all
from benchmarks.navigation.barn.environment import DT, Environment
from benchmarks.navigation.barn.jackal import FOOTPRINT, LENGTH, MAX_ANGULAR, MAX_LINEAR, NOISE, WIDTH
from benchmarks.navigation.barn.navigator import PERIOD, BarnNavigator
from benchmarks.navigation.barn.worlds import GOAL, GOAL_TOLERANCE, START, TIME_LIMIT, BarnWorld
from ppaas.geometry import Pose2D
from robots.sim.drivetrain import DrivetrainModel

REVERSE = -0.5
"""Maximum reverse velocity [m/s]."""


def make_navigator(planner: str, goal: Pose2D, drive: DrivetrainModel) -> BarnNavigator:
    """Return a navigator that uses a local planner.

    Parameters
    ----------
    planner : str
        Name of the plug-in; planners other than ``mppi`` use their defaults and the robot's radius.
    goal : Pose2D
        Goal relative to the robot's start [m].
    drive : DrivetrainModel
        Known properties of the motors: speeds, accelerations, delay and lag.
    """
    return BarnNavigator(goal, planner, _parameters(planner, drive))


def _parameters(planner: str, drive: DrivetrainModel) -> dict[str, Any]:
    if planner == "mppi":
        return {
            "max_vel_x": MAX_LINEAR, "min_vel_x": REVERSE, "max_vel_theta": MAX_ANGULAR,
            "acc_lim_x": drive.acc_linear, "acc_lim_theta": drive.acc_angular,
            "command_delay": drive.delay, "motor_lag": drive.lag,
            "footprint": FOOTPRINT, "robot_radius": math.hypot(LENGTH, WIDTH) / 2,
        }  # fmt: skip
    return {"robot_radius": WIDTH / 2}


STEPS = round(PERIOD / DT)

Outcome = Literal["success", "collision", "timeout"]


@dataclass(frozen=True, slots=True)
class BarnJob:
    """Settings of a run.

    Parameters
    ----------
    world : BarnWorld
    planner : str
        Name of the local planner's plug-in.
    noise : str
        Noise level, a key of `benchmarks.navigation.barn.jackal.NOISE`.
    seed, run : int
        All noise depends on these and the number of the world alone.
    """

    world: BarnWorld
    planner: str
    noise: str
    seed: int
    run: int


@dataclass(frozen=True, slots=True)
class BarnResult:
    """Result of a run.

    Parameters
    ----------
    world, run : int
    outcome : str
    seconds : float
        Duration of the run [s].
    best_time : float
        Time of the reference path at full speed [s].
    clearance : float
        Smallest distance between the footprint and a cylinder [m].
    """

    world: int
    run: int
    outcome: Outcome
    seconds: float
    best_time: float
    clearance: float

    @property
    def score(self) -> float:
        """The metric of the BARN challenge: OT / clip(AT, 2·OT, 8·OT) for a success, else 0."""
        if self.outcome != "success":
            return 0.0
        return self.best_time / float(np.clip(self.seconds, 2.0 * self.best_time, 8.0 * self.best_time))


Watch = Callable[[Environment, BarnNavigator], None]


def drive(job: BarnJob, watch: Watch | None = None) -> BarnResult:
    """Simulate a run, faster than real time.

    Parameters
    ----------
    job : BarnJob
    watch : callable, optional
        Called with the environment and the navigator after each control cycle.
    """
    environment = Environment(job.world, NOISE[job.noise], np.random.default_rng((job.seed, job.world.world, job.run)))
    # The goal relative to the start, as the navigator expects it.
    x, y, _ = START.inverse() @ GOAL
    navigator = make_navigator(job.planner, Pose2D(x, y), NOISE[job.noise].drive)
    clearance = environment.clearance()
    while True:
        environment.command(navigator.drive(environment.odometry(), environment.scan()))
        for _ in range(STEPS):
            environment.step()
            clearance = min(clearance, environment.clearance())
            outcome = _judge(environment, clearance)
            if outcome is not None:
                return BarnResult(job.world.world, job.run, outcome, environment.time, job.world.best_time, clearance)
        if watch is not None:
            watch(environment, navigator)


def _judge(environment: Environment, clearance: float) -> Outcome | None:
    if clearance <= 0.0:
        return "collision"
    if environment.pose.distance_to(GOAL) <= GOAL_TOLERANCE:
        return "success"
    return "timeout" if environment.time >= TIME_LIMIT else None


# -- all runs of the BARN bench, in parallel processes, and their summary ----------------------------------------------


@dataclass(frozen=True, slots=True)
class BarnOptions:
    """Settings of the BARN bench.

    Parameters
    ----------
    runs : int
        Number of runs in each world.
    planner, noise : str
        Local planner and noise level, as in `benchmarks.navigation.barn.run.BarnJob`.
    seed : int
        Seed of all noise.
    jobs : int
        Number of processes.
    """

    runs: int
    planner: str
    noise: str
    seed: int
    jobs: int


def measure(worlds: Sequence[BarnWorld], options: BarnOptions, done: Callable[[], None]) -> list[BarnResult]:
    """Simulate all runs; return the results in the order of worlds and runs.

    Parameters
    ----------
    worlds : sequence of BarnWorld
    options : BarnOptions
    done : callable
        Called after each run.
    """
    return run_all(drive, jobs_of(worlds, options), options.jobs, done)


def jobs_of(worlds: Sequence[BarnWorld], options: BarnOptions) -> list[BarnJob]:
    """Return all runs, in the order of worlds and runs."""
    return [
        BarnJob(world, options.planner, options.noise, options.seed, run)
        for world in worlds
        for run in range(options.runs)
    ]


def summary(results: Sequence[BarnResult]) -> dict[str, Any]:
    """Return the summary of runs: shares by outcome, and means.

    ``metric`` is the mean score. ``at_over_ot`` is the mean ratio of the duration to the time of the reference path at
    full speed, over successful runs. ``min_clearance`` is the smallest clearance of any run [m].
    """
    successes = [result for result in results if result.outcome == "success"]
    times = [result.seconds / result.best_time for result in successes]
    return {
        "worlds": len({result.world for result in results}),
        "runs": len(results),
        **{name: _share(results, name) for name in ("success", "collision", "timeout")},
        "metric": round(float(np.mean([result.score for result in results])), 4),
        "at_over_ot": round(float(np.mean(times)), 3) if times else None,
        "min_clearance": round(min(result.clearance for result in results), 4),
    }


def _share(results: Sequence[BarnResult], outcome: str) -> float:
    return round(sum(result.outcome == outcome for result in results) / len(results), 4)
