"""Simulated worlds of the bench of merging: an office, its mirror image, and long corridors."""

from collections.abc import Callable

import numpy as np

from benchmarks.mapping.office import LENGTH, office, route
from benchmarks.mapping.simulated_drive import Segments, SimulatedDrive, simulate

WIDTH = 2.2
"""Width of the corridors [m]."""

NICHE = 0.3
"""Depth of the doors of a corridor [m]."""


def mirrored_office() -> SimulatedDrive:
    """Return the drive through the office, seen in a mirror."""
    walls, points = office(0), route()
    walls[:, (0, 2)] = LENGTH - walls[:, (0, 2)]
    points[:, 0] = LENGTH - points[:, 0]
    return simulate(walls, points, 5)


def bare_corridor(length: float, seed: int) -> SimulatedDrive:
    """Return a drive to and fro in a corridor without doors [m]."""
    ends = [(0.0, 0.0, 0.0, WIDTH), (length, 0.0, length, WIDTH)]
    sides = [(0.0, y, length, y) for y in (0.0, WIDTH)]
    return simulate(np.array([*ends, *sides]), _to_and_fro(10.0, length - 10.0), seed)


def corridor_with_doors(begin: float, end: float, seed: int) -> SimulatedDrive:
    """Return a drive between two places of an 80 m long corridor, with equal doors every 5 m on both sides [m]."""
    walls = [(0.0, 0.0, 0.0, WIDTH), (80.0, 0.0, 80.0, WIDTH)]
    for y, out in ((0.0, -NICHE), (WIDTH, NICHE)):
        walls += _doors(y, y + out)
    return simulate(np.array(walls), _to_and_fro(begin, end), seed)


def _doors(wall: float, back: float) -> list[tuple[float, float, float, float]]:
    segments = []
    for left in np.arange(2.0, 80.0, 5.0).tolist():
        right = left + 1.0
        segments += [
            (left - 4.0 if left > 2.0 else 0.0, wall, left, wall), (left, wall, left, back),
            (left, back, right, back), (right, back, right, wall),
        ]  # fmt: skip
    return [*segments, (78.0, wall, 80.0, wall)]


def _to_and_fro(begin: float, end: float) -> Segments:
    return np.array([(begin, WIDTH / 2.0), (end, WIDTH / 2.0), (begin + 2.0, WIDTH / 2.0)])


WORLDS: dict[str, Callable[[], SimulatedDrive]] = {
    "office 0": lambda: simulate(office(0), route(), 0),
    "mirrored office": mirrored_office,
    "corridor of 90 m": lambda: bare_corridor(90.0, 13),
    "corridor of 110 m": lambda: bare_corridor(110.0, 14),
    "corridor with doors, part 1": lambda: corridor_with_doors(10.0, 45.0, 11),
    "corridor with doors, part 2": lambda: corridor_with_doors(35.0, 70.0, 12),
}
"""Drives by name; each two are of different buildings, or of places that look alike."""
