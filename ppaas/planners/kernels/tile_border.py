"""Kernel parts: what a tile takes from its neighbours, and which of them it wakes."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.kernels import simd
from ppaas.planners.kernels.tile_layout import (
    BASE,
    BOTTOM,
    BOTTOM_LEFT,
    BOTTOM_RIGHT,
    CELLS,
    COST,
    EDGES,
    FACTOR,
    FREE,
    HALF,
    KIND,
    LEFT,
    LIMIT,
    MIXED,
    RIGHT,
    ROOT,
    ROOT_SHIFT,
    SIDE,
    TABLE,
    TOP,
    TOP_LEFT,
    TOP_RIGHT,
    UNKNOWN,
    UNREACHED,
)  # fmt: skip
from ppaas.planners.kernels.tile_plane import BESIDE, SPARE, relaxed, slanted, weighed

Int = int | np.signedinteger[Any]
Numbers = NDArray[np.uint32]
Bytes = NDArray[np.uint8]

LAST = SIDE - 1


@njit(cache=True, nogil=True, error_model="numpy")
def look_around(tile: Int, across: Int, tiles: Int, scratch: Numbers) -> None:
    """Write the numbers of the tiles around one to scratch memory; ``tiles`` stands for all that is outside."""
    column = tile % across
    at_left, at_right = column == 0, column == across - 1
    at_top, at_bottom = tile < across, tile + across >= tiles
    scratch[BESIDE + TOP] = tiles if at_top else tile - across
    scratch[BESIDE + BOTTOM] = tiles if at_bottom else tile + across
    scratch[BESIDE + LEFT] = tiles if at_left else tile - 1
    scratch[BESIDE + RIGHT] = tiles if at_right else tile + 1
    scratch[BESIDE + TOP_LEFT] = tiles if at_top or at_left else tile - across - 1
    scratch[BESIDE + TOP_RIGHT] = tiles if at_top or at_right else tile - across + 1
    scratch[BESIDE + BOTTOM_LEFT] = tiles if at_bottom or at_left else tile + across - 1
    scratch[BESIDE + BOTTOM_RIGHT] = tiles if at_bottom or at_right else tile + across + 1


@njit(cache=True, nogil=True, error_model="numpy", forceinline=True)
def beside(scratch: Numbers, move: Int) -> Int:
    """Return the tile on one side, or at one corner, of the one worked on."""
    return np.int64(scratch[BESIDE + move])


@njit(cache=True, nogil=True, error_model="numpy", forceinline=True)
def edge(tables: Numbers, tile: Int, side: Int) -> Any:
    """Return the values of the cells of a tile along one of its sides."""
    return simd.load(tables, tile * TABLE + EDGES + side * SIDE)


@njit(cache=True, nogil=True, error_model="numpy", forceinline=True)
def free_along(tables: Numbers, tile: Int, side: Int) -> Int:
    """Return which cells of a tile along one of its sides are free."""
    line = side // 2 * SIDE + (LAST if side in (BOTTOM, RIGHT) else 0)
    return np.int64(tables[tile * TABLE + FREE + line])


@njit(cache=True, nogil=True, error_model="numpy")
def _weights_along(tables: Numbers, costs: Bytes, tile: Int, side: Int, scratch: Numbers) -> Any:
    """Return what the cells of a tile along one of its sides weigh."""
    first = tile * CELLS + (LAST * SIDE if side == BOTTOM else LAST if side == RIGHT else 0)
    if tables[tile * TABLE + KIND] != MIXED:
        return weighed(simd.splat(np.int64(tables[tile * TABLE + COST])))
    if side in (TOP, BOTTOM):
        return weighed(simd.load_bytes(costs, first))
    for row in range(SIDE):
        scratch[SPARE + row] = costs[first + row * SIDE]
    return weighed(simd.load(scratch, SPARE))


@njit(cache=True, nogil=True, error_model="numpy")
def wake_side(tables: Numbers, costs: Bytes, tile: Int, side: Int, values: Any, scratch: Numbers) -> Int:
    """Return the least value that a tile's edge would give to the neighbour there; `UNREACHED` if it betters none."""
    other, facing = beside(scratch, side), side ^ 1
    free, own = free_along(tables, other, facing), free_along(tables, tile, side)
    weights = _weights_along(tables, costs, other, facing, scratch)
    before = edge(tables, other, facing)
    after = relaxed(values, before, free, own & (free << 1), own & (free >> 1), weights, slanted(weights))
    better = simd.less(after, before)
    return simd.least_of(simd.where(better, after, simd.splat(UNREACHED))) if better else UNREACHED


@njit(cache=True, nogil=True, error_model="numpy")
def _is_passable(tables: Numbers, move: Int, scratch: Numbers) -> bool:
    """Return whether a diagonal move over a corner of the tile worked on cuts no obstacle."""
    down, right = move in (BOTTOM_LEFT, BOTTOM_RIGHT), move in (TOP_RIGHT, BOTTOM_RIGHT)
    above, aside = beside(scratch, BOTTOM if down else TOP), beside(scratch, RIGHT if right else LEFT)
    column, row = (LAST if right else 0), (LAST if down else 0)
    vertical = free_along(tables, above, TOP if down else BOTTOM) >> column
    horizontal = free_along(tables, aside, LEFT if right else RIGHT) >> row
    return (vertical & horizontal & 1) != 0


@njit(cache=True, nogil=True, error_model="numpy")
def over_corner(tables: Numbers, costs: Bytes, tile: Int, move: Int, into: bool, scratch: Numbers) -> Int:
    """Return the value that a diagonal move over a corner of a tile gives.

    Parameters
    ----------
    tables, costs, tile, scratch
        The tile worked on.
    move : int
        Which corner.
    into : bool
        Whether the move leads into the tile, not out of it.

    Returns
    -------
    int
        `UNREACHED` where the move cannot be made or betters nothing.
    """
    other = beside(scratch, move)
    source, target, back = (other, tile, move) if into else (tile, other, move ^ 3)
    column, row = (
        (LAST if back in (TOP_RIGHT, BOTTOM_RIGHT) else 0),
        (LAST if back in (BOTTOM_LEFT, BOTTOM_RIGHT) else 0),
    )
    free = np.int64(tables[target * TABLE + FREE + row]) >> column & 1
    if free == 0 or not _is_passable(tables, move, scratch):
        return UNREACHED
    table = target * TABLE
    mixed = tables[table + KIND] == MIXED
    cost = np.int64(costs[target * CELLS + row * SIDE + column]) if mixed else np.int64(tables[table + COST])
    weight = UNKNOWN if cost == 255 else BASE + FACTOR * cost
    value = value_at(tables, source, back ^ 3) + ((weight * ROOT + HALF) >> ROOT_SHIFT)
    return value if value < value_at(tables, target, back) else UNREACHED


@njit(cache=True, nogil=True, error_model="numpy", forceinline=True)
def value_at(tables: Numbers, tile: Int, move: Int) -> Int:
    """Return the value of the cell of a tile at a corner."""
    side = BOTTOM if move in (BOTTOM_LEFT, BOTTOM_RIGHT) else TOP
    lane = LAST if move in (TOP_RIGHT, BOTTOM_RIGHT) else 0
    return np.int64(tables[tile * TABLE + EDGES + side * SIDE + lane])


@njit(cache=True, nogil=True, error_model="numpy", forceinline=True)
def too_long(values: Any) -> bool:
    """Return whether a value of a line is so large that others may be too large for the field."""
    return bool(simd.less(simd.splat(LIMIT), values) & simd.less(values, simd.splat(UNREACHED)))
