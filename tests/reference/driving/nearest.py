"""Twin of the kernel that finds nearest points."""

import math


def nearest(points, others, reach):
    """Return for each point the index of the nearest other point, or -1 if none is in reach."""
    found = []
    for point in points:
        away = [math.dist(point[:2], other[:2]) for other in others]
        within = [(distance, index) for index, distance in enumerate(away) if distance <= reach]
        found.append(min(within)[1] if within else -1)
    return found
