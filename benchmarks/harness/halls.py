"""Halls: the part in which robots drive, the lanes that a person would draw, and the places of goals."""

import itertools
from collections.abc import Sequence
from random import Random

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.figures import Figure
from ppaas.costmap.build_layers import build_layers
from ppaas.fleet.lattice_roadmap import LatticeRoadmap
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.roadmap import BLOCKED, Roadmap
from ppaas.maps.grid import OCCUPIED, GridMap
from ppaas.zones.shapes import LineString
from ppaas.zones.zone import NO_ZONES, Lane, Zone, ZoneSet


def largest_part(roadmap: Roadmap) -> list[int]:
    """Return the cells of the largest part of a roadmap whose cells are connected, in ascending order."""
    left, best = set(range(len(roadmap))), set[int]()
    while left:
        part, new = set[int](), {left.pop()}
        while new:
            part.update(new)
            new = {int(n) for cell in new for n in roadmap.neighbours[cell] if n in left}
            left.difference_update(new)
        best = max(best, part, key=len)
    return sorted(best)


# -- places of goals ---------------------------------------------------------------------------------------------------

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


# -- lanes of a hall with aisles, as a person would draw them ----------------------------------------------------------

LANES = "lanes"
"""Name of the halls of benches that have lanes; they are warehouses."""

ASIDE = 0.5
"""Distance of both lanes from the line between them [m]."""

CLEARANCE = 0.45
"""Least distance of lanes from obstacles [m]."""

NARROWEST = 2.0
"""Least width of an aisle that gets lanes [m]."""

FULL = 0.1
"""Part of a row or column of the map from which on, if occupied, it is no part of an aisle."""


def zones_of_hall(name: str, grid: GridMap) -> ZoneSet:
    """Return the zones of a hall with a name and a map: lanes if it is that one."""
    return right_hand_lanes(grid) if name == LANES else NO_ZONES


def right_hand_lanes(grid: GridMap) -> ZoneSet:
    """Return two one-way lanes in each aisle along the rows and along the columns of a map.

    An aisle along the rows has none between two cross aisles where something stands in it. Aisles along the columns are
    the cross aisles; one in which something stands has no lanes.
    """
    clear = build_layers(grid).to_lethal >= CLEARANCE
    rows = _middles(grid, axis=1)
    columns = [each for each in _middles(grid, axis=0) if _is_clear_aisle(clear.T, grid, each, rows[0], rows[-1])]
    parts = list(itertools.pairwise(columns))
    used = [(row, part) for row, part in itertools.product(rows, parts) if _is_clear_aisle(clear, grid, row, *part)]
    whole = [row for row in rows if all((row, part) in used for part in parts)]  # cross aisles end at these
    lanes = []
    for column in columns:
        x, low, high = _x(grid, column), _y(grid, whole[0]) - ASIDE, _y(grid, whole[-1]) + ASIDE
        lanes.append((f"cross aisle {x:.1f} north", [[x + ASIDE, low], [x + ASIDE, high]]))
        lanes.append((f"cross aisle {x:.1f} south", [[x - ASIDE, high], [x - ASIDE, low]]))
    for row, (begin, end) in used:
        if whole[0] <= row <= whole[-1]:
            y, left, right = _y(grid, row), _x(grid, begin) - ASIDE, _x(grid, end) + ASIDE
            lanes.append((f"aisle {y:.1f} from {left:.1f} east", [[left, y - ASIDE], [right, y - ASIDE]]))
            lanes.append((f"aisle {y:.1f} from {left:.1f} west", [[right, y + ASIDE], [left, y + ASIDE]]))
    return ZoneSet([Zone(LineString(line), Lane(name=name, one_way=True)) for name, line in lanes])


def _middles(grid: GridMap, axis: int) -> list[int]:
    """Return the index along the rows or columns of the middle of each aisle."""
    empty = (grid.data >= OCCUPIED).mean(axis=axis) < FULL
    ends = np.flatnonzero(np.diff(np.pad(empty.astype(np.int8), 1)))
    runs = zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True)
    return [(begin + end) // 2 for begin, end in runs if (end - begin) * grid.info.resolution >= NARROWEST]


def _is_clear_aisle(clear: NDArray[np.bool_], grid: GridMap, index: int, begin: int, end: int) -> bool:
    """Return whether nothing stands in both lanes of an aisle between two indices along it."""
    aside = round(ASIDE / grid.info.resolution)
    return bool(clear[[index - aside, index + aside], begin - aside : end + aside].all())


def _x(grid: GridMap, column: int) -> float:
    return float(grid.info.to_world((0, column))[0])


def _y(grid: GridMap, row: int) -> float:
    return float(grid.info.to_world((row, 0))[1])
