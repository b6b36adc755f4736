"""Simulated worlds of the mapping bench: corridors, and others by their names.

The corridors are endless: two of 240 m and four of 60 m that join them. All walls have equal doors at equal distances,
so that a scan looks the same every few metres, every junction like any other, and a lap is longer than the odometry
can be trusted. Some doors are open: these are what a mapper can hold on to. The walls are segments (n, 4): x0, y0, x1,
y1 [m].
"""

import itertools

import numpy as np
from numpy.typing import NDArray

from benchmarks.mapping import laboratory
from benchmarks.mapping.office import office, route
from benchmarks.mapping.simulated_drive import Segments, SimulatedDrive, simulate

LENGTH, DEPTH = 240.0, 60.0
"""Distances between the middles of the outermost corridors [m]."""
CROSSINGS = (0.0, 80.0, 160.0, 240.0)
"""Middles of the corridors that join the two long ones [m]."""
HALF = 1.2
"""Half the width of a corridor [m]."""
PITCH, DOOR, RECESS, OPEN = 6.0, 1.0, 0.15, 3.0
"""Distance of doors, their width, and the depth of a closed and of an open one [m]."""
SHARE = 0.1
"""Part of the doors that is open."""


def corridors(seed: int, share: float = SHARE) -> Segments:
    """Return the walls.

    Parameters
    ----------
    seed : int
        Chooses the open doors.
    share : float
        Part of the doors that is open; with 0, all corridors are equal.
    """
    random = np.random.default_rng(seed)
    low, top = -HALF, DEPTH + HALF
    left, right = CROSSINGS[0] - HALF, CROSSINGS[-1] + HALF
    walls = [
        _wall((left, low), (right, low), -1.0, share, random), _wall((left, top), (right, top), 1.0, share, random),
        _wall((left, low), (left, top), 1.0, share, random), _wall((right, low), (right, top), -1.0, share, random),
    ]  # fmt: skip
    for begin, end in itertools.pairwise(CROSSINGS):
        x0, x1, y0, y1 = begin + HALF, end - HALF, HALF, DEPTH - HALF
        walls += [
            _wall((x0, y0), (x1, y0), 1.0, share, random), _wall((x0, y1), (x1, y1), -1.0, share, random),
            _wall((x0, y0), (x0, y1), -1.0, share, random), _wall((x1, y0), (x1, y1), 1.0, share, random),
        ]  # fmt: skip
    return np.concatenate(walls)


def corridor_route() -> NDArray[np.float64]:
    """Return the way points (n, 2) of some 1.9 km: a lap, the cross corridors, and the lap in the other direction."""
    lap = [(0.0, 0.0), (LENGTH, 0.0), (LENGTH, DEPTH), (0.0, DEPTH)]
    second, third = CROSSINGS[1:3]
    across = [(0.0, 0.0), (second, 0.0), (second, DEPTH), (third, DEPTH), (third, 0.0), (LENGTH, 0.0), (LENGTH, DEPTH)]
    return np.array([*lap, *across, (0.0, DEPTH), (0.0, 0.0), (0.0, DEPTH), (LENGTH, DEPTH), (LENGTH, 0.0), (0.0, 0.0)])


def _wall(
    begin: tuple[float, float], end: tuple[float, float], out: float, share: float, random: np.random.Generator
) -> Segments:
    """Return a wall with doors; they recede to the left of its direction with ``out`` 1, to the right with −1."""
    start, along = np.array(begin), np.subtract(end, begin)
    length = float(np.hypot(*along))
    along = along / length
    away = out * np.array((-along[1], along[0]))
    points = [start]
    for place in np.arange(PITCH / 2.0, length - PITCH / 4.0, PITCH):
        depth = OPEN if random.random() < share else RECESS
        left, right = start + (place - DOOR / 2.0) * along, start + (place + DOOR / 2.0) * along
        points += [left, left + depth * away, right + depth * away, right]
    points.append(np.array(end))
    line = np.array(points)
    return np.hstack((line[:-1], line[1:]))


OFFICE, LABORATORY, CORRIDORS, EQUAL_CORRIDORS = "office", "laboratory", "corridors", "equal corridors"
"""Names of the worlds. In the equal corridors no door is open."""


def walls_of(world: str, seed: int) -> Segments:
    """Return the walls (n, 4) of a world: x0, y0, x1, y1 [m]."""
    if world == LABORATORY:
        return laboratory.laboratory(seed).walls
    if world == EQUAL_CORRIDORS:
        return corridors(seed, 0.0)
    return corridors(seed) if world == CORRIDORS else office(seed)


def drive_of(world: str, seed: int, sweep: float = 0.0) -> SimulatedDrive:
    """Return a drive through a world.

    Parameters
    ----------
    world : str
    seed : int
        Seed of the world, and of all noise.
    sweep : float
        Time that the laser takes for a scan [s].
    """
    walls = walls_of(world, seed)
    if world == LABORATORY:
        return simulate(walls, laboratory.laboratory(seed).route, seed, sweep=sweep, speed=laboratory.SPEED)
    return simulate(walls, route() if world == OFFICE else corridor_route(), seed, sweep=sweep)
