"""Validation of history rows before they are stored."""

import math

from ppaas.errors import InvalidInput
from ppaas.plans.history import MOST_BUCKETS, LinkHistory, PlannerHistory
from storage.names import check_name

MAX_INCREMENT = 1 << 50
"""Largest number that one row adds to a sum: no store's 64-bit integers overflow."""


def check_history(row: PlannerHistory) -> PlannerHistory:
    """Return the row; ``InvalidInput`` if a name is not valid, or a number is out of range."""
    check_name("map", row.map)
    check_name("version", row.version)
    check_name("planner", row.planner)
    if not 0 <= row.bucket < MOST_BUCKETS:
        raise InvalidInput(f"bucket: {row.bucket} is not between 0 and {MOST_BUCKETS - 1}")
    if any(not 0 <= count <= MAX_INCREMENT for count in row.counts()):
        raise InvalidInput(
            f"history of {row.planner!r} on map {row.map!r}: a sum is negative or exceeds {MAX_INCREMENT}"
        )
    return row


def check_link(row: LinkHistory) -> LinkHistory:
    """Return the row; ``InvalidInput`` if its name is not valid, or a number is negative or not finite."""
    check_name("link", row.link)
    numbers = row.round_trip, row.bandwidth, row.measured
    if not all(map(math.isfinite, numbers)) or min(*numbers, row.answers) < 0:
        raise InvalidInput(f"history of link {row.link!r}: all numbers must be finite and not negative")
    return row
