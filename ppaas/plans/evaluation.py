"""Evaluation of planners on a map from their history (planner evaluation of the paper, section V)."""

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import reduce
from itertools import groupby
from typing import Any

from ppaas.plans.history import LOG_UNITS, PlannerHistory, bucket_range


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
