"""Slow, obvious twins of turns: directions as vectors, and the turns between them by their angle."""

import itertools
from collections.abc import Sequence

from ppaas.fleet.roadmap import Roadmap

Direction = tuple[int, int]

DIRECTIONS: tuple[Direction, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1))


def direction(roadmap: Roadmap, start: int, end: int) -> Direction:
    """Return by how many rows and columns a move leads."""
    rows, columns = (roadmap.cells[end] - roadmap.cells[start]).tolist()
    return rows, columns


def quarters(before: Direction, after: Direction) -> int:
    """Return the number of quarter turns between two directions, by their scalar product."""
    return 1 - (before[0] * after[0] + before[1] * after[1])


def count(roadmap: Roadmap, path: Sequence[int]) -> int:
    """Return the number of quarter turns on a path."""
    stops = [cell for k, cell in enumerate(path) if k == 0 or cell != path[k - 1]]
    ways = [direction(roadmap, here, there) for here, there in itertools.pairwise(stops)]
    return sum(quarters(one, other) for one, other in itertools.pairwise(ways))
