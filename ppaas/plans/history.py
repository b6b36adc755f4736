"""Statistics of planning requests, and the evaluation of planners from them.

They are sums whose size does not depend on the number of requests. All sums are integers: rows can be added in any
order, also by a store that can only count.
"""

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import reduce
from itertools import groupby
from operator import add
from typing import Any

import msgspec

from ppaas.geometry import Pose2D
from ppaas.plans.stored import Origin

LOG_UNITS = 1000
"""Units of 1 in sums of logarithms."""

MOST_BUCKETS = 64
"""Number of complexity buckets."""


class PlannerHistory(msgspec.Struct, frozen=True):
    """Statistics of the requests of one complexity to one planner on one map version.

    Parameters
    ----------
    map, version, planner : str
        Key of the row.
    bucket : int
        Complexity: half octaves of the distance between start and goal in cells (`bucket_of`).
    queries, failed : int
        Number of requests, and of those that ended without a plan.
    computed, reused, stitched : int
        Number of plans by origin.
    micros : int
        Total time of computed plans [µs].
    logs, squares : int
        Sums of the natural logarithm of each of these times in microseconds, and of its square, in 1/1000.
    compared : int
        Number of computed plans that were compared with the cheapest plan for the same request.
    millimetres, cheapest_millimetres : int
        Total lengths of those plans, and of the cheapest ones [mm].
    """

    map: str
    version: str
    planner: str
    bucket: int
    queries: int = 0
    failed: int = 0
    computed: int = 0
    reused: int = 0
    stitched: int = 0
    micros: int = 0
    logs: int = 0
    squares: int = 0
    compared: int = 0
    millimetres: int = 0
    cheapest_millimetres: int = 0

    @property
    def key(self) -> tuple[str, str, str, int]:
        """Key of the row: map, version, planner, bucket. A store has one row per key."""
        return self.map, self.version, self.planner, self.bucket

    def counts(self) -> tuple[int, ...]:
        """Return the sums, in the order of their fields."""
        return msgspec.structs.astuple(self)[len(KEY) :]

    def plus(self, other: "PlannerHistory") -> "PlannerHistory":
        """Return the sums of both rows, under the key of this one."""
        return PlannerHistory(*self.key, *map(add, self.counts(), other.counts()))


KEY, COUNTS = PlannerHistory.__struct_fields__[:4], PlannerHistory.__struct_fields__[4:]
"""Names of the fields that form the key, and of the fields that are sums."""


class LinkHistory(msgspec.Struct, frozen=True):
    """Recent speed of one link to the plan store; a newer row replaces the older one.

    Parameters
    ----------
    link : str
        Machine and store that the link connects.
    round_trip : float
        Time of an answer without a plan [s].
    bandwidth : float
        Rate at which plans arrive [bytes/s].
    answers : int
        Number of answers measured so far.
    measured : float
        Time of the last measurement [s since the epoch].
    """

    link: str
    round_trip: float
    bandwidth: float
    answers: int
    measured: float


def complexity(start: Pose2D, goal: Pose2D, resolution: float) -> float:
    """Return the octile distance between two poses [cells], a lower bound of the length of a path from cell to cell."""
    across, up = abs(goal.x - start.x), abs(goal.y - start.y)
    return (max(across, up) + (math.sqrt(2.0) - 1.0) * min(across, up)) / resolution


def bucket_of(cells: float) -> int:
    """Return the bucket of a complexity: 0 up to one cell, then one bucket for each half octave."""
    if not cells > 1.0:
        return 0
    return 1 + int(min(2.0 * math.log2(cells), MOST_BUCKETS - 2.0))


def bucket_range(bucket: int) -> tuple[float, float]:
    """Return the range of complexities of a bucket [cells], upper end excluded."""
    return 0.0 if bucket == 0 else 2.0 ** ((bucket - 1) / 2.0), 2.0 ** (bucket / 2.0)


def computed_row(key: tuple[str, str, str, int], seconds: float) -> PlannerHistory:
    """Return the row of one computed plan."""
    log = math.log(max(seconds * 1e6, 1.0))
    return PlannerHistory(
        *key, queries=1, computed=1, micros=round(seconds * 1e6),
        logs=round(log * LOG_UNITS), squares=round(log * log * LOG_UNITS),
    )  # fmt: skip


def failed_row(key: tuple[str, str, str, int]) -> PlannerHistory:
    """Return the row of one request that ended without a plan."""
    return PlannerHistory(*key, queries=1, failed=1)


def found_row(key: tuple[str, str, str, int], origin: Origin) -> PlannerHistory:
    """Return the row of one plan that was reused or stitched."""
    stitched = int(origin == "stitched")
    return PlannerHistory(*key, queries=1, reused=1 - stitched, stitched=stitched)


def compared_row(key: tuple[str, str, str, int], length: float, cheapest: float) -> PlannerHistory:
    """Return the row of one comparison between the length of a plan and the length of the cheapest one [m]."""
    return PlannerHistory(
        *key, compared=1, millimetres=round(length * 1000), cheapest_millimetres=round(cheapest * 1000)
    )


# -- evaluation of the planners on a map (planner evaluation of the paper, section V) ----------------------------------


@dataclass(frozen=True, slots=True)
class Performance:
    """Summary of the requests to a planner.

    Parameters
    ----------
    queries : int
        Number of requests.
    success : float or None
        Fraction of them that got a plan; None without requests.
    computed, reused, stitched : int
        Number of plans by origin.
    reuse_rate : float or None
        Fraction of the plans that were not computed.
    seconds, typical_seconds : float or None
        Arithmetic and geometric mean of the computing time [s].
    spread : float or None
        Typical factor between a computing time and the typical one (geometric standard deviation).
    compared : int
        Number of computed plans that were compared with the cheapest plan from cell to cell.
    over_cheapest : float or None
        Fraction by which they were longer than it; below 0 for a planner that does not move from cell to cell.
    """

    queries: int
    success: float | None
    computed: int
    reused: int
    stitched: int
    reuse_rate: float | None
    seconds: float | None
    typical_seconds: float | None
    spread: float | None
    compared: int
    over_cheapest: float | None


@dataclass(frozen=True, slots=True)
class Complexity:
    """Performance on requests whose start and goal are ``cells[0]`` up to ``cells[1]`` cells apart."""

    cells: tuple[float, float]
    performance: Performance


@dataclass(frozen=True, slots=True)
class PlannerEvaluation:
    """Performance of one planner, in total and by the distance between start and goal."""

    planner: str
    performance: Performance
    complexities: tuple[Complexity, ...]


def evaluate(rows: Iterable[PlannerHistory]) -> list[PlannerEvaluation]:
    """Return the evaluation of each planner, ordered by name; rows may belong to several versions of a map."""
    ordered = sorted(rows, key=lambda row: (row.planner, row.bucket))
    return [_evaluation(planner, list(own)) for planner, own in groupby(ordered, key=lambda row: row.planner)]


def as_json(evaluation: PlannerEvaluation) -> dict[str, Any]:
    """Return an evaluation as a JSON object."""
    complexities = [{"cells": list(each.cells), **asdict(each.performance)} for each in evaluation.complexities]
    return {"planner": evaluation.planner, **asdict(evaluation.performance), "complexities": complexities}


def _evaluation(planner: str, rows: list[PlannerHistory]) -> PlannerEvaluation:
    parts = groupby(rows, key=lambda row: row.bucket)
    complexities = tuple(Complexity(bucket_range(bucket), _performance(list(own))) for bucket, own in parts)
    return PlannerEvaluation(planner, _performance(rows), complexities)


def _performance(rows: list[PlannerHistory]) -> Performance:
    sums = reduce(PlannerHistory.plus, rows)
    found = sums.reused + sums.stitched
    plans = sums.computed + found
    mean_log = _ratio(sums.logs / LOG_UNITS, sums.computed)
    variance = None if mean_log is None else max(sums.squares / LOG_UNITS / sums.computed - mean_log**2, 0.0)
    longer = _ratio(sums.millimetres, sums.cheapest_millimetres)
    return Performance(
        queries=sums.queries,
        success=_ratio(sums.queries - sums.failed, sums.queries),
        computed=sums.computed,
        reused=sums.reused,
        stitched=sums.stitched,
        reuse_rate=_ratio(found, plans),
        seconds=_ratio(sums.micros / 1e6, sums.computed),
        typical_seconds=None if mean_log is None else math.exp(mean_log) / 1e6,
        spread=None if variance is None else math.exp(math.sqrt(variance)),
        compared=sums.compared,
        over_cheapest=None if longer is None else longer - 1.0,
    )


def _ratio(some: float, of: float) -> float | None:
    return some / of if of else None
