"""Simulated laboratory: many rooms of different widths around two rings of doors, entered one after the other, slowly.

It stands in for the log of Intel's laboratory: 180 beams, about 450 m in three quarters of an hour. Its corridors and
rooms have other measures than those of the office. The walls are segments (n, 4): x0, y0, x1, y1 [m].
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.mapping.simulated_drive import Segments, box

LENGTH, DEPTH = 26.0, 16.0
"""Outer size of the ring of corridors [m]."""
CORRIDOR = 1.8
"""Width of the corridors [m]."""
OUTER = 4.0
"""Depth of the rooms outside the ring [m]."""
INNER = (DEPTH - 2.0 * CORRIDOR) / 2.0
"""Depth of the rooms inside the ring [m]; two rows of them are back to back."""
WIDTHS = (2.4, 5.0)
"""Smallest and largest width of a room [m]."""
DOOR, JAMB = 0.9, 0.12
"""Width of doors, and depth of their frames [m]."""
SPEED = 0.18
"""Largest speed of the robot [m/s]."""


@dataclass(frozen=True, slots=True)
class Laboratory:
    """Laboratory, and a route through it.

    Parameters
    ----------
    walls : (n, 4) array
    route : (m, 2) array
        Way points: a lap that enters the outer rooms, one that enters the inner ones, and one in the other direction.
    """

    walls: Segments
    route: NDArray[np.float64]


def laboratory(seed: int) -> Laboratory:
    """Return a laboratory; the seed chooses the widths of the rooms, and places doors and furniture."""
    random = np.random.default_rng(seed)
    right, top = LENGTH - CORRIDOR, DEPTH - CORRIDOR
    outer = [
        _Row((0.0, 0.0), (LENGTH, 0.0), -1.0, OUTER), _Row((LENGTH, 0.0), (LENGTH, DEPTH), -1.0, OUTER),
        _Row((LENGTH, DEPTH), (0.0, DEPTH), -1.0, OUTER), _Row((0.0, DEPTH), (0.0, 0.0), -1.0, OUTER),
    ]  # fmt: skip
    inner = [
        _Row((CORRIDOR, CORRIDOR), (right, CORRIDOR), 1.0, INNER), _Row((right, top), (CORRIDOR, top), 1.0, INNER),
    ]  # fmt: skip
    walls, visits = zip(*(row.build(random) for row in (*outer, *inner)), strict=True)
    middle = CORRIDOR / 2.0
    corners = np.array([(middle, middle), (LENGTH - middle, middle), (LENGTH - middle, DEPTH - middle),
                        (middle, DEPTH - middle)])  # fmt: skip
    first = [points for side, corner in zip(visits[:4], corners, strict=True) for points in (corner[None], side)]
    second = [corners[:1], visits[4], corners[1:3], visits[5], corners[3:]]
    route = np.concatenate([*first, *second, corners[:1], corners[::-1]])
    return Laboratory(np.concatenate(walls), route)


@dataclass(frozen=True, slots=True)
class _Row:
    """Row of rooms along a corridor, from ``begin`` to ``end``; ``out`` is 1 if they are left of it, −1 if right."""

    begin: tuple[float, float]
    end: tuple[float, float]
    out: float
    depth: float

    def build(self, random: np.random.Generator) -> tuple[Segments, NDArray[np.float64]]:
        """Return the walls and the furniture, and way points (m, 2) that enter each room and leave it."""
        start, along = np.array(self.begin), np.subtract(self.end, self.begin)
        length = float(np.hypot(*along))
        axes = np.array((along / length, self.out * np.array((-along[1], along[0])) / length))
        walls, visits = [box(length / 2.0, self.depth / 2.0, length, self.depth, 0.0)[1:]], []
        for left, right in _rooms(length, random):
            door = random.uniform(left + DOOR, right - DOOR)
            walls += [_front(left, right, door, self.depth), _furniture(left, right, self.depth, random)]
            visits += [(door, -CORRIDOR / 2.0), (door, self.depth / 2.0), (door, -CORRIDOR / 2.0)]
        ends = np.concatenate(walls).reshape(-1, 2)
        return (ends @ axes + start).reshape(-1, 4), np.array(visits) @ axes + start


def _rooms(length: float, random: np.random.Generator) -> list[tuple[float, float]]:
    """Return the left and the right end of each room of a row [m]."""
    widths = random.uniform(*WIDTHS, round(length / np.mean(WIDTHS)))
    ends = np.concatenate(([0.0], np.cumsum(widths))) * length / widths.sum()
    return list(zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True))


def _front(left: float, right: float, door: float, depth: float) -> Segments:
    """Return the wall of a room with its door, and the wall to the next room."""
    begin, end = door - DOOR / 2.0, door + DOOR / 2.0
    frame = [(x, 0.0, x, JAMB) for x in (begin, end)]
    return np.array([(left, 0.0, begin, 0.0), *frame, (end, 0.0, right, 0.0), (right, 0.0, right, depth)])


def _furniture(left: float, right: float, depth: float, random: np.random.Generator) -> Segments:
    boxes = [
        box(
            random.uniform(left + 0.4, right - 0.4), random.uniform(0.8, 0.95) * depth, random.uniform(0.3, 1.0),
            random.uniform(0.2, 0.5), random.uniform(0.0, 3.0),
        )
        for _ in range(random.integers(2, 6))
    ]  # fmt: skip
    return np.concatenate(boxes)
