"""Cutting plans into chunks and finding them, one after the other and plainly."""

import math


def cuts(hashes: list[int], granularity: int) -> list[int]:
    """Return before which waypoints a plan is cut: the largest hashes around, of equal ones the last."""
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
    """Tell whether both ends of a plan are near two places."""
    return math.dist(first, start) <= tolerance and math.dist(last, goal) <= tolerance
