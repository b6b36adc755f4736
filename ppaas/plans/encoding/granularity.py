"""Granularity of the segments that plans share: how long a shared part must be."""

from ppaas.errors import InvalidInput

GRANULARITY = 16
"""Granularity G of the paper (``ppaas.plans.encoding.chunks``) [waypoints]: at most length / G segments of a plan are
shared, and a shared part longer than G becomes an entry."""

MOST_GRANULARITY = 65536
"""Largest granularity [waypoints]."""


def inner_granularity(granularity: int) -> int:
    """Return the granularity to cut with, which is half of the paper's.

    A shared part slightly longer than G may contain no whole chunk of G waypoints, but usually contains one of G / 2.

    Raises
    ------
    InvalidInput
        The granularity is not from 2 to 65536.
    """
    if not 2 <= granularity <= MOST_GRANULARITY:
        raise InvalidInput(f"granularity: {granularity} is not from 2 to {MOST_GRANULARITY} waypoints")
    return granularity // 2
