"""Slow, obvious twin of the smoother: nav2_smoother's iteration, repeated until it converges."""

import math

Points = list[list[float]]


def relax(points: Points, near: list[float], even: float, rounds: int) -> Points:
    """Return the converged points x, y; those with an infinite data weight are fixed."""
    found = [list(point) for point in points]
    for _ in range(rounds):
        for at in range(1, len(points) - 1):
            if math.isinf(near[at]):
                continue
            for axis in range(2):
                pull = near[at] * (points[at][axis] - found[at][axis])
                pull += even * (found[at - 1][axis] + found[at + 1][axis] - 2.0 * found[at][axis])
                found[at][axis] += pull / (near[at] + 2.0 * even)
    return found
