"""Places of goals, anywhere in a cell of a roadmap where a robot touches no blocked one, and how near robots get."""

from collections.abc import Sequence
from random import Random

import numpy as np

from benchmarks.harness.figures import Figure
from ppaas.fleet.lattice_roadmap import LatticeRoadmap
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.roadmap import BLOCKED

BESIDE = 0.45
"""Largest distance of goals from the centres of cells along x and along y, in distances of neighbouring cells."""


def goal_in(cell: int, hall: MetricRoadmap, radius: float, rng: Random, beside: float = BESIDE) -> tuple[float, float]:
    """Return a random place in a cell at which a robot touches no square that is blocked or outside of the hall.

    It is the centre of the cell if the first that is drawn is not such a place.

    Parameters
    ----------
    cell : int
    hall : MetricRoadmap
    radius : float
        Radius of the robot [m].
    rng : Random
    beside : float
        Largest distance of the place from the centre along x and along y, in distances of neighbouring cells.
    """
    x, y = hall.centre(cell)
    most = beside * hall.spacing
    place = (x + rng.uniform(-most, most), y + rng.uniform(-most, most)) if most else (x, y)
    return (x, y) if isinstance(hall, LatticeRoadmap) and not _is_clear(hall, *place, radius) else place


def distance_figure(part: str, name: str, misses: Sequence[float]) -> Figure:
    """Return the figure of the distances from goals at which robots reported them as reached [m], at least one."""
    return Figure(
        part, f"{name}: distance from goals that were reached", round(float(np.median(misses)), 3), "m",
        note=f"95 % within {np.percentile(misses, 95.0):.3f} m",
    )  # fmt: skip


def _is_clear(hall: LatticeRoadmap, x: float, y: float, radius: float) -> bool:
    numbers, spacing = np.pad(hall.roadmap.numbers, 1, constant_values=BLOCKED), hall.spacing
    row, column = round((y - hall.y0) / spacing), round((x - hall.x0) / spacing)
    rows, columns = np.nonzero(numbers[row : row + 3, column : column + 3] == BLOCKED)
    dy = np.abs(hall.y0 + spacing * (row - 1 + rows) - y) - spacing / 2.0
    dx = np.abs(hall.x0 + spacing * (column - 1 + columns) - x) - spacing / 2.0
    return bool((np.hypot(np.maximum(dx, 0.0), np.maximum(dy, 0.0)) >= radius).all())
