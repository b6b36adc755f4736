"""Generated maps: an office and a warehouse, to plan and drive in without a map file.

The same seed gives the same map. Two objects either touch or leave a gap wide enough for a robot of 0.3 m radius, so
the free space of such a robot is connected.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from ppaas.errors import InvalidParameter
from ppaas.maps.discs import stamp_disc
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap

Cells = NDArray[np.int8]

_WALL = 0.15
_CORRIDOR = 2.0
_DOOR = (1.0, 1.4)
_DOORSTEP = 1.2  # depth of the area behind a door that is kept clear
_ROOM_WIDTH = 4.5
_BAND = 15.0  # height served by one corridor: rooms, corridor, rooms
_GAP = 0.8  # smallest gap between two pieces of furniture, or between one and a wall that it does not touch

_RACK = 1.0
_AISLE = 2.6
_CROSS_AISLE = 3.0
_STAGING = 5.0  # width of the staging area, which has pallets instead of racks
_RACKS_BETWEEN = 9.0  # approximate length of racks between two cross aisles
_BAY = 2.7
_PALLET = (1.2, 0.8)
_PALLET_GAP = 1.2


class _Piece(NamedTuple):
    """Piece of furniture: length and depth [m], whether it touches a wall, and whether it is round."""

    length: float
    depth: float
    at_wall: bool
    round: bool = False


class _Space(NamedTuple):
    """Area to furnish: its cells, which of them are taken or kept clear, and the edge of a cell [m]."""

    inside: Cells
    reserved: NDArray[np.bool_]
    resolution: float


_DESK = _Piece(1.6, 0.8, at_wall=True)
_CABINET = _Piece(1.0, 0.45, at_wall=True)
_ROUND_TABLE = _Piece(1.1, 1.1, at_wall=False, round=True)
_BIN = _Piece(0.35, 0.35, at_wall=True, round=True)
_FURNITURE = (_DESK, _CABINET, _DESK, _ROUND_TABLE, _BIN)


def office(seed: int = 0, width: float = 24.0, height: float = 16.0, resolution: float = 0.05) -> GridMap:
    """Return an office: corridors with rooms on both sides, doors at least 1 m wide, furniture.

    Parameters
    ----------
    seed : int
        The same seed gives the same map.
    width, height : float
        Size of the map including the outer walls [m]; at least 9 × 10. There is a corridor per 15 m of height, and a
        cross corridor connects several corridors.
    resolution : float
        Edge of a cell [m], at most 0.1.

    Raises
    ------
    InvalidParameter
        The map is too small for rooms, or its cells are too coarse for doors.
    """
    cells, info = _empty(width, height, resolution, least=(9.0, 10.0))
    rng = np.random.default_rng(seed)
    bands = max(1, round(height / _BAND))
    edges = [round(band * info.height / bands) for band in range(bands + 1)]
    spans = _spans(rng, info, crossed=bands > 1)
    half = _cells(_CORRIDOR / 2, resolution)
    for bottom, top in pairwise(edges):
        middle = (bottom + top) // 2
        for left, right in spans:
            _rooms(rng, cells[bottom : middle - half, left:right], resolution)
            # Flipped, since `_rooms` puts the doors at the top, and here the corridor is below.
            _rooms(rng, cells[middle + half : top, left:right][::-1], resolution)
    _wall_in(cells, resolution)
    return GridMap(cells, info)


def _spans(rng: Generator, info: GridInfo, crossed: bool) -> list[tuple[int, int]]:
    """Return the column ranges for rooms: all columns, or those left and right of a cross corridor."""
    if not crossed:
        return [(0, info.width)]
    half = _cells(_CORRIDOR / 2, info.resolution)
    middle = int(info.width * rng.uniform(0.4, 0.6))
    return [(0, middle - half), (middle + half, info.width)]


def _rooms(rng: Generator, row: Cells, resolution: float) -> None:
    """Divide an area below a corridor into a row of rooms with doors to the corridor, and furnish them."""
    count = max(1, round(row.shape[1] * resolution / _ROOM_WIDTH))
    inner = (np.arange(1, count) + rng.uniform(-0.12, 0.12, count - 1)) / count
    edges = [0, *(inner * row.shape[1]).astype(int).tolist(), row.shape[1]]
    for left, right in pairwise(edges):
        _room(rng, row[:, left:right], resolution)


def _room(rng: Generator, room: Cells, resolution: float) -> None:
    _wall_in(room, resolution)
    wall = _cells(_WALL, resolution)
    space = _space(room[wall:-wall, wall:-wall], resolution)
    door = _cells(rng.uniform(*_DOOR), resolution)
    start = int(rng.integers(0, space.inside.shape[1] - door + 1))
    room[-wall:, wall + start : wall + start + door] = FREE
    space.reserved[-_cells(_DOORSTEP, resolution) :, start : start + door] = True
    for piece in _FURNITURE:
        _place(rng, space, piece, _GAP)


def _space(inside: Cells, resolution: float) -> _Space:
    return _Space(inside, np.zeros(inside.shape, np.bool_), resolution)


def _place(rng: Generator, space: _Space, piece: _Piece, gap: float) -> None:
    """Try 20 random positions for a piece, and draw it at the first that keeps the gap to all reserved cells."""
    inside, reserved, resolution = space
    clear = _cells(gap, resolution)
    for _ in range(20):
        sides = (_cells(piece.length, resolution), _cells(piece.depth, resolution))
        height, width = sides if rng.random() < 0.5 else sides[::-1]
        row, at_row = _position(rng, inside.shape[0], height, clear, piece.at_wall)
        column, at_column = _position(rng, inside.shape[1], width, clear, piece.at_wall)
        if row is None or column is None or (piece.at_wall and not (at_row or at_column)):
            continue
        around = reserved[max(row - clear, 0) : row + height + clear, max(column - clear, 0) : column + width + clear]
        if not around.any():
            around_piece = (slice(row, row + height), slice(column, column + width))
            reserved[around_piece] = True
            _draw(inside[around_piece], piece)
            return


def _position(rng: Generator, space: int, size: int, clear: int, at_wall: bool) -> tuple[int | None, bool]:
    """Choose a position along one side of a room, and whether it is at a wall; None if the piece does not fit."""
    if at_wall and space - size >= clear and rng.random() < 0.4:
        return (0 if rng.random() < 0.5 else space - size), True
    if space - size < 2 * clear:
        return None, False
    return int(rng.integers(clear, space - size - clear + 1)), False


def _draw(cells: Cells, piece: _Piece) -> None:
    if piece.round:
        height, width = cells.shape
        stamp_disc(cells.view(np.uint8), width / 2, height / 2, min(height, width) / 2, OCCUPIED)
    else:
        cells[:] = OCCUPIED


def warehouse(seed: int = 0, width: float = 30.0, height: float = 20.0, resolution: float = 0.05) -> GridMap:
    """Return a warehouse: rows of racks with aisles of at least 2.6 m, cross aisles, pallets and a staging area.

    Parameters
    ----------
    seed : int
        The same seed gives the same map.
    width, height : float
        Size of the map including the outer walls [m]; at least 15 × 8.
    resolution : float
        Edge of a cell [m], at most 0.1.

    Raises
    ------
    InvalidParameter
        The map is too small for racks, or its cells are too coarse for aisles.
    """
    cells, info = _empty(width, height, resolution, least=(15.0, 8.0))
    rng = np.random.default_rng(seed)
    _wall_in(cells, resolution)
    wall = _cells(_WALL, resolution)
    hall = cells[wall:-wall, wall:-wall]
    rows = int((hall.shape[0] * resolution - _AISLE) / (_RACK + _AISLE))
    aisle = (hall.shape[0] - rows * _cells(_RACK, resolution)) / (rows + 1)
    bottoms = [round(row * (aisle + _cells(_RACK, resolution)) + aisle) for row in range(rows)]
    for left, right in _segments(hall.shape[1], resolution):
        for bottom in bottoms:
            _racks(rng, hall[bottom : bottom + _cells(_RACK, resolution), left:right], resolution)
            _pallet_at_rack(rng, hall[:bottom, left:right], resolution)
    staging = _space(hall[:, : _cells(_STAGING, resolution)], resolution)
    pallet = _Piece(*_PALLET, at_wall=False)
    for _ in range(max(2, int(height / 3))):
        _place(rng, staging, pallet, _PALLET_GAP)
    return GridMap(cells, info)


def _segments(hall: int, resolution: float) -> list[tuple[int, int]]:
    """Return the column ranges of racks, with a cross aisle between two ranges and along the right wall."""
    cross = _cells(_CROSS_AISLE, resolution)
    start, stop = _cells(_STAGING, resolution), hall - cross
    count = max(1, round((stop - start) * resolution / (_RACKS_BETWEEN + _CROSS_AISLE)))
    length = (stop - start - (count - 1) * cross) // count
    return [(start + i * (length + cross), start + i * (length + cross) + length) for i in range(count)]


def _racks(rng: Generator, row: Cells, resolution: float) -> None:
    """Fill a row with bays of racks, leaving out some at random."""
    bays = max(1, round(row.shape[1] * resolution / _BAY))
    edges = np.linspace(0, row.shape[1], bays + 1).astype(int)
    for left, right in pairwise(edges):
        if rng.random() > 0.08:
            row[:, left:right] = OCCUPIED


def _pallet_at_rack(rng: Generator, below: Cells, resolution: float) -> None:
    """Put a pallet into the aisle, against the rack above, with a probability of 1/4."""
    length, depth = (_cells(side, resolution) for side in _PALLET)
    if rng.random() < 0.25 and below.shape[1] > length:
        column = int(rng.integers(0, below.shape[1] - length))
        below[-depth:, column : column + length] = OCCUPIED


def _empty(width: float, height: float, resolution: float, least: tuple[float, float]) -> tuple[Cells, GridInfo]:
    if not (width >= least[0] and height >= least[1]):
        raise InvalidParameter(
            f"width and height must be at least {least[0]} and {least[1]} m, not {width} and {height}"
        )
    if not 0.0 < resolution <= 0.1:
        raise InvalidParameter(f"resolution must be above 0 and at most 0.1 m, not {resolution}")
    info = GridInfo(resolution, _cells(width, resolution), _cells(height, resolution))
    return np.full(info.shape, FREE, np.int8), info


def _wall_in(cells: Cells, resolution: float) -> None:
    wall = _cells(_WALL, resolution)
    cells[:wall] = cells[-wall:] = OCCUPIED
    cells[:, :wall] = cells[:, -wall:] = OCCUPIED


def _cells(length: float, resolution: float) -> int:
    return max(1, round(length / resolution))
