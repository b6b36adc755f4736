"""A run in the simulated world: drives, localizes, and compares the estimates with the true poses."""

import math
from collections import deque
from dataclasses import dataclass
from itertools import chain
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.localization.scene import Errors, LocalizationScene
from ppaas.maps.grid import GridMap

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
