"""How planners did on a map, from its history (the planner evaluation of the paper, section V)."""

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import reduce
from itertools import groupby
from typing import Any

from ppaas.plans.history import LOG_UNITS, PlannerHistory, bucket_range


@dataclass(frozen=True, slots=True)
class Performance:
    """What became of requests.

    Parameters
    ----------
    queries : int
        How many there were.
    success : float or None
        Part of them that got a plan; None where there were none.
    computed, reused, stitched : int
        Where the plans came from.
    reuse_rate : float or None
        Part of the plans that was not computed.
    seconds, typical_seconds : float or None
        Mean and geometric mean of the time it took to compute one [s].
    spread : float or None
        Factor by which times typically differ from the typical one.
    compared : int
        How many of those computed were compared with the cheapest plan from cell to cell.
    over_cheapest : float or None
        By which part of its length they were longer; below 0 where a planner need not go from cell to cell.
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
    """What became of requests whose start and goal are so many cells apart, from the first up to the second."""

    cells: tuple[float, float]
    performance: Performance


@dataclass(frozen=True, slots=True)
class PlannerEvaluation:
    """How one planner did: in all, and by the distance between start and goal."""

    planner: str
    performance: Performance
    complexities: tuple[Complexity, ...]


def evaluate(rows: Iterable[PlannerHistory]) -> list[PlannerEvaluation]:
    """Return how each planner did, by name; rows may be of several versions of a map."""
    ordered = sorted(rows, key=lambda row: (row.planner, row.bucket))
    return [_evaluation(planner, list(own)) for planner, own in groupby(ordered, key=lambda row: row.planner)]


def as_json(evaluation: PlannerEvaluation) -> dict[str, Any]:
    """Return an evaluation as JSON has it."""
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
    mean_log = _part(sums.logs / LOG_UNITS, sums.computed)
    variance = None if mean_log is None else max(sums.squares / LOG_UNITS / sums.computed - mean_log**2, 0.0)
    longer = _part(sums.millimetres, sums.cheapest_millimetres)
    return Performance(
        queries=sums.queries,
        success=_part(sums.queries - sums.failed, sums.queries),
        computed=sums.computed,
        reused=sums.reused,
        stitched=sums.stitched,
        reuse_rate=_part(found, plans),
        seconds=_part(sums.micros / 1e6, sums.computed),
        typical_seconds=None if mean_log is None else math.exp(mean_log) / 1e6,
        spread=None if variance is None else math.exp(math.sqrt(variance)),
        compared=sums.compared,
        over_cheapest=None if longer is None else longer - 1.0,
    )


def _part(some: float, of: float) -> float | None:
    return some / of if of else None
