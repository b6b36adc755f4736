"""Slow, obvious twin of `ppaas.plans.encoding.chunks`, and of the search by ends."""

import math


def cuts(hashes: list[int], granularity: int) -> list[int]:
    """Return the waypoints before which a plan is cut: local maxima of the hashes, the last of equal ones."""
    first, last = 1, len(hashes) - 2
    if last - first < granularity:
        return []
    found = [first]
    for at in range(first + granularity, last - granularity):
        before = hashes[at - granularity : at]
        behind = hashes[at + 1 : at + granularity + 1]
        if hashes[at] >= max(before) and hashes[at] > max(behind):
            found.append(at)
    return [*found, last]


def near(first, last, start, goal, tolerance: float) -> bool:
    """Return whether both ends of a plan are near two positions."""
    return math.dist(first, start) <= tolerance and math.dist(last, goal) <= tolerance
