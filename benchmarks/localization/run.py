"""One run in the simulated world: drive, localize beside it, and compare with where the robot really is."""

import math
from collections import deque
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.localization.scene import LocalizationScene
from ppaas.maps.grid import GridMap

LOST, LOST_TURN = 0.5, math.radians(20.0)
"""A robot that is told to be farther off than this is lost [m, rad]."""

BEFORE = 10.0
"""A robot is carried off, or people crowd around it, after this way [m]."""

JAM = 80.0
"""They go away again after this time [s]."""

CERTAIN = 2.0
"""A robot is found where it is lost no more to the end of its way, and that is at least so far [m]."""

Kind = Literal["track", "kidnap", "global", "jam"]


@dataclass(frozen=True, slots=True)
class LocalizationJob:
    """What to run.

    Parameters
    ----------
    grid : GridMap
    kind : {"track", "kidnap", "global", "jam"}
        The robot is told where it starts; is told so, and carried off later; is not told; is told so, and people crowd
        around it later.
    metres : float
        To drive; after it was carried off, after people have gone, or from the start [m].
    parameters : dict
        Of amcl.
    seed, run : int
        What is left to chance depends on these and the kind, and nothing else.
    people : int
        Who crowd around it.
    """

    grid: GridMap
    kind: Kind
    metres: float
    parameters: dict[str, Any]
    seed: int
    run: int
    people: int = 0


@dataclass(frozen=True, slots=True)
class LocalizationResult:
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


def drive(job: LocalizationJob) -> LocalizationResult:
    """Drive one run, faster than real time."""
    rng = np.random.default_rng((job.seed, job.run, len(job.kind)))
    scene = LocalizationScene(job.grid, {"seed": job.run, **job.parameters}, rng, told=job.kind != "global")
    if job.kind in ("kidnap", "jam"):
        deque(scene.drive(BEFORE), maxlen=0)
    if job.kind == "kidnap":
        scene.carry_off()
    begin = scene.way
    rows = list(scene.jam(job.people, JAM)) if job.kind == "jam" else []
    rows += scene.drive(job.metres)
    return _judge(job, np.array(rows), begin, float(np.mean(scene.localizer.seconds)))


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


def _judge(job: LocalizationJob, rows: NDArray[np.float64], begin: float, seconds: float) -> LocalizationResult:
    way, error, turn = rows.T
    way = way - begin
    fine = (error <= LOST) & (turn <= LOST_TURN)
    known = job.kind in ("track", "jam")
    found = 0.0 if known else found_after(way, fine)
    if found is None:
        return LocalizationResult(job.run, math.nan, math.nan, math.nan, math.nan, True, None, float(way[-1]), seconds)
    # The way alone would not do: a robot that turns in place goes none.
    since = 0 if known else held_from(fine)
    error, turn = error[since:], turn[since:]
    lost = known and not bool(fine.all())
    return LocalizationResult(
        job.run, float(error.mean()), float(turn.mean()), float(error.max()), float(turn.max()), lost, found,
        float(way[-1]), seconds,
    )  # fmt: skip
