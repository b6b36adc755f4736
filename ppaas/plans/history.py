"""What became of requests for plans, in sums that take the same room however many there were.

All are whole numbers, so that rows can be added in any order, and by a store that only counts.
"""

import math
from operator import add

import msgspec

from ppaas.geometry import Pose2D
from ppaas.plans.stored import Origin

LOG_UNITS = 1000
"""Parts of one in sums of logarithms."""

MOST_BUCKETS = 64


class PlannerHistory(msgspec.Struct, frozen=True):
    """What became of the requests to one planner on one map version, of one complexity.

    Parameters
    ----------
    map, version, planner : str
        What it is about.
    bucket : int
        Complexity: half octaves of the distance between start and goal in cells (`bucket_of`).
    queries, failed : int
        Requests, and how many of them ended without a plan.
    computed, reused, stitched : int
        Where the other plans came from.
    micros : int
        Time of those computed, in all [µs].
    logs, squares : int
        Sums of the natural logarithm of each of these times in microseconds, and of its square, in 1/1000.
    compared : int
        How many of those computed were compared with the cheapest plan for the same request.
    millimetres, cheapest_millimetres : int
        Lengths of those, and of the cheapest ones [mm].
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
        """What a store keeps one row for."""
        return self.map, self.version, self.planner, self.bucket

    def counts(self) -> tuple[int, ...]:
        """Return the sums, in the order of their fields."""
        return msgspec.structs.astuple(self)[len(KEY) :]

    def plus(self, other: "PlannerHistory") -> "PlannerHistory":
        """Return the sums of both, under the key of this."""
        return PlannerHistory(*self.key, *map(add, self.counts(), other.counts()))


KEY, COUNTS = PlannerHistory.__struct_fields__[:4], PlannerHistory.__struct_fields__[4:]
"""Names of the fields that say what a row is of, and of those that are sums."""


class LinkHistory(msgspec.Struct, frozen=True):
    """How fast plans came over one link, of late; a newer row takes the place of the one before.

    Parameters
    ----------
    link : str
        From which machine to the store.
    round_trip : float
        Until an answer without a plan is there [s].
    bandwidth : float
        Of plans [bytes/s].
    answers : int
        How many answers were measured, in all.
    measured : float
        When the last one was [s since the epoch].
    """

    link: str
    round_trip: float
    bandwidth: float
    answers: int
    measured: float


def complexity(start: Pose2D, goal: Pose2D, resolution: float) -> float:
    """Return the octile distance between two poses, in cells: the least that a path from cell to cell is long."""
    across, up = abs(goal.x - start.x), abs(goal.y - start.y)
    return (max(across, up) + (math.sqrt(2.0) - 1.0) * min(across, up)) / resolution


def bucket_of(cells: float) -> int:
    """Return the bucket of a complexity: 0 up to one cell, then one for each half octave."""
    if not cells > 1.0:
        return 0
    return 1 + int(min(2.0 * math.log2(cells), MOST_BUCKETS - 2.0))


def bucket_range(bucket: int) -> tuple[float, float]:
    """Return the complexities of a bucket, in cells: from the first up to the second."""
    return 0.0 if bucket == 0 else 2.0 ** ((bucket - 1) / 2.0), 2.0 ** (bucket / 2.0)


def computed_row(key: tuple[str, str, str, int], seconds: float) -> PlannerHistory:
    """Return the row of one plan that was computed."""
    log = math.log(max(seconds * 1e6, 1.0))
    return PlannerHistory(
        *key, queries=1, computed=1, micros=round(seconds * 1e6),
        logs=round(log * LOG_UNITS), squares=round(log * log * LOG_UNITS),
    )  # fmt: skip


def failed_row(key: tuple[str, str, str, int]) -> PlannerHistory:
    """Return the row of one request without a plan."""
    return PlannerHistory(*key, queries=1, failed=1)


def found_row(key: tuple[str, str, str, int], origin: Origin) -> PlannerHistory:
    """Return the row of one plan that was not computed but found."""
    stitched = int(origin == "stitched")
    return PlannerHistory(*key, queries=1, reused=1 - stitched, stitched=stitched)


def compared_row(key: tuple[str, str, str, int], length: float, cheapest: float) -> PlannerHistory:
    """Return the row of a comparison of a plan's length with that of the cheapest one [m]."""
    return PlannerHistory(
        *key, compared=1, millimetres=round(length * 1000), cheapest_millimetres=round(cheapest * 1000)
    )
