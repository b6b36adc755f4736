"""Simulated office: a ring of corridors with rooms on two sides, furniture in the rooms, and a route through it.

The office is 40 × 30 m. The walls are segments (n, 4): x0, y0, x1, y1 [m].
"""

import numpy as np
from numpy.typing import NDArray

from benchmarks.mapping.simulated_drive import Segments, box

LENGTH, DEPTH = 40.0, 20.0
"""Outer size of the ring of corridors [m]."""
CORRIDOR = 2.2
"""Width of the corridors [m]."""
ROOMS, ROOM = 8, 5.0
"""Number of rooms on each long side, and their edge [m]."""
DOOR, JAMB = 1.0, 0.1
"""Width of doors, and depth of their frames [m]."""
FURNITURE = 4
"""Pieces of furniture in each room."""
MIDDLE = CORRIDOR / 2.0
"""Distance of the route from the outer walls of the corridors [m]."""


def office(seed: int) -> Segments:
    """Return the walls and the furniture; the seed places the furniture."""
    random = np.random.default_rng(seed)
    parts = [_ring(), _inner_block(random)]
    for wall, out in ((0.0, -1.0), (DEPTH, 1.0)):
        parts += [_wall_with_doors(wall, out), _rooms(wall, out), _furniture(wall + out * 3.9, random)]
    return np.concatenate(parts)


def route() -> NDArray[np.float64]:
    """Return the way points (n, 2) of two laps, each of which enters every other room on both sides [m]."""
    doors = [ROOM * (room + 0.5) for room in range(ROOMS)]
    south, north = MIDDLE, DEPTH - MIDDLE
    points = [(MIDDLE, south)]
    for lap in range(2):
        for places, along, into in ((doors, south, -2.9), (doors[::-1], north, 2.9)):
            for number, x in enumerate(places):
                points.append((x, along))
                if number % 2 == lap:
                    points += [(x, along + into), (x, along)]
            end = LENGTH - MIDDLE if along == south else MIDDLE
            points += [(end, along), (end, DEPTH - along)]
    return np.array(points)


def _ring() -> Segments:
    """Return the two short outer walls; the long ones have doors."""
    return np.array([(0.0, 0.0, 0.0, DEPTH), (LENGTH, 0.0, LENGTH, DEPTH)])


def _inner_block(random: np.random.Generator) -> Segments:
    """Return the walls inside the ring, with cupboards that stand out from them."""
    low, right, top = CORRIDOR, LENGTH - CORRIDOR, DEPTH - CORRIDOR
    walls = [box((low + right) / 2.0, (low + top) / 2.0, right - low, top - low, 0.0)]
    for x in np.arange(5.0, 37.0, 6.5):
        walls.append(box(x, low - 0.05, random.uniform(0.8, 1.2), 0.2, 0.0))
        walls.append(box(x + 1.0, top + 0.05, random.uniform(0.8, 1.2), 0.2, 0.0))
    return np.concatenate(walls)


def _wall_with_doors(y: float, out: float) -> Segments:
    """Return a long wall of the corridor with a door to each room; door frames reach into the rooms."""
    segments = []
    begin = 0.0
    for room in range(ROOMS):
        left = ROOM * (room + 0.5) - DOOR / 2.0
        segments.append((begin, y, left, y))
        segments += [(x, y, x, y + out * JAMB) for x in (left, left + DOOR)]
        begin = left + DOOR
    return np.array([*segments, (begin, y, LENGTH, y)])


def _rooms(y: float, out: float) -> Segments:
    back = y + out * ROOM
    sides = [(ROOM * room, y, ROOM * room, back) for room in range(ROOMS + 1)]
    return np.array([*sides, (0.0, back, LENGTH, back)])


def _furniture(y: float, random: np.random.Generator) -> Segments:
    boxes = [
        box(
            ROOM * room + random.uniform(0.5, ROOM - 0.5), y + random.uniform(-0.4, 0.4), random.uniform(0.3, 1.4),
            random.uniform(0.3, 0.8), random.uniform(0.0, 3.0),
        )
        for room in range(ROOMS)
        for _ in range(FURNITURE)
    ]  # fmt: skip
    return np.concatenate(boxes)
