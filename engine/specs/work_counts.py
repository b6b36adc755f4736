"""Counts of what containers have done, for metrics: plans with their times, and goals of the robots' own clients.

A container reports what it has done to its machine once a second. The machine adds that up, and reports the sums to the
master with its load. All counts are whole numbers by name, of a fixed set of names.
"""

from bisect import bisect_left
from collections import Counter
from collections.abc import Mapping
from typing import Final

from ppaas.errors import InvalidParameter
from ppaas.messages.actionlib_msgs import Status
from ppaas.plans.history import PlannerHistory
from ppaas.tasks.records import GOALS

REST_GOALS: Final = "rest-"
"""Beginning of the ids of goals of REST."""

FOLLOWED: Final = (GOALS, REST_GOALS)
"""Beginnings of the ids of goals that the master sends, follows and counts itself."""

PLAN_SECONDS = 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0
"""Upper limits of the classes of planning times [s]: a small map takes less than a millisecond, a large one seconds."""

CLASSES: Final = tuple(f"plans in class {number}" for number in range(len(PLAN_SECONDS) + 1))
"""Names of the numbers of plans that were computed, by their time; the last class has no limit."""

PLAN_MICROS, REUSED, STITCHED, FAILED = "plan microseconds", "plans reused", "plans stitched", "plans failed"

ENDED: Final = {status: f"goals {status.name.lower()}" for status in Status if status.terminal}
"""Names of the numbers of goals that have ended, by their status."""

NAMES: Final = frozenset((*CLASSES, PLAN_MICROS, REUSED, STITCHED, FAILED, *ENDED.values()))

MOST: Final = 1 << 53
"""Largest count: the numbers of a scrape are floating-point numbers."""


def plan_counts(row: PlannerHistory) -> Counter[str]:
    """Return the counts of one request for a plan."""
    counted = Counter({REUSED: row.reused, STITCHED: row.stitched, FAILED: row.failed})
    if row.computed:
        counted[CLASSES[bisect_left(PLAN_SECONDS, row.micros / 1e6)]] = row.computed
        counted[PLAN_MICROS] = row.micros
    return +counted


def add_counts(total: Counter[str], more: Mapping[str, int]) -> None:
    """Add counts of another process to a total, which stays at `MOST` when it has reached that.

    Raises
    ------
    InvalidParameter
        As `check_counts`; the total is unchanged.
    """
    check_counts(more)
    for name, number in more.items():
        total[name] = min(total[name] + number, MOST)


def check_counts(counts: Mapping[str, int]) -> None:
    """Check counts of another process.

    Raises
    ------
    InvalidParameter
        A name is unknown, or a number is out of range.
    """
    for name, number in counts.items():
        if name not in NAMES:
            raise InvalidParameter(f"nothing is counted as {name[:40]!r}")
        if not 0 <= number <= MOST:
            raise InvalidParameter(f"{number} {name} are not within 0 to {MOST}")
