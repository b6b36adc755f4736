"""What a row of history must be, so that stores keep it."""

import math

from ppaas.errors import InvalidInput
from ppaas.plans.history import MOST_BUCKETS, LinkHistory, PlannerHistory
from storage.names import check_name

LARGEST = 1 << 50
"""Most that one row adds to a sum: then no store's whole numbers are ever used up."""


def check_history(row: PlannerHistory) -> PlannerHistory:
    """Return a row that stores keep; ``InvalidInput`` if its names are no names, or a number is out of range."""
    check_name("map", row.map)
    check_name("version", row.version)
    check_name("planner", row.planner)
    if not 0 <= row.bucket < MOST_BUCKETS:
        raise InvalidInput(f"bucket: {row.bucket} is not from 0 to {MOST_BUCKETS - 1}")
    if any(not 0 <= count <= LARGEST for count in row.counts()):
        raise InvalidInput(f"history of {row.planner!r} on map {row.map!r}: a sum is negative or above {LARGEST}")
    return row


def check_link(row: LinkHistory) -> LinkHistory:
    """Return a row that stores keep; ``InvalidInput`` if its name is no name, or a number is none."""
    check_name("link", row.link)
    numbers = row.round_trip, row.bandwidth, row.measured
    if not all(map(math.isfinite, numbers)) or min(*numbers, row.answers) < 0:
        raise InvalidInput(f"history of link {row.link!r}: its numbers must be finite and not negative")
    return row
