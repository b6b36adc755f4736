"""Lanes of a hall with aisles, as a person would draw them: two one-way lanes in each, on which robots keep right."""

import itertools

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.build_layers import build_layers
from ppaas.maps.grid import OCCUPIED, GridMap
from ppaas.zones.shapes import LineString
from ppaas.zones.zone import NO_ZONES, Lane, Zone, ZoneSet

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
    columns = [each for each in _middles(grid, axis=0) if _is_clear(clear.T, grid, each, rows[0], rows[-1])]
    parts = list(itertools.pairwise(columns))
    used = [(row, part) for row, part in itertools.product(rows, parts) if _is_clear(clear, grid, row, *part)]
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


def _is_clear(clear: NDArray[np.bool_], grid: GridMap, index: int, begin: int, end: int) -> bool:
    """Return whether nothing stands in both lanes of an aisle between two indices along it."""
    aside = round(ASIDE / grid.info.resolution)
    return bool(clear[[index - aside, index + aside], begin - aside : end + aside].all())


def _x(grid: GridMap, column: int) -> float:
    return float(grid.info.to_world((0, column))[0])


def _y(grid: GridMap, row: int) -> float:
    return float(grid.info.to_world((row, 0))[1])
