"""A BARN run: the robot drives until it arrives, collides, or exceeds the time limit; and its score."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from benchmarks.navigation.barn.controller_setups import make_navigator
from benchmarks.navigation.barn.environment import DT, Environment
from benchmarks.navigation.barn.jackal import NOISE
from benchmarks.navigation.barn.navigator import PERIOD, Navigator
from benchmarks.navigation.barn.worlds import GOAL, GOAL_TOLERANCE, START, TIME_LIMIT, BarnWorld
from ppaas.geometry import Pose2D

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


Watch = Callable[[Environment, Navigator], None]


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
