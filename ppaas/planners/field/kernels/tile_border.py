"""Kernel parts: moves across the borders of a tile, and which neighbours they improve."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, joined
from ppaas.planners.field.kernels.tile_layout import (
    BASE,
    BOTTOM,
    BOTTOM_LEFT,
    BOTTOM_RIGHT,
    CELLS,
    COLUMNS,
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
    TOUCHED,
    UNKNOWN,
    UNREACHED,
)  # fmt: skip
from ppaas.planners.field.kernels.tile_rows import BESIDE, LAST, SEEN, SELF, SPARE, relaxed, slanted, weighed
from ppaas.planners.kernels import atomics, simd

Int = int | np.signedinteger[Any]
Numbers = NDArray[np.uint32]
Bytes = NDArray[np.uint8]


@bare
def find_neighbours(tile: Int, across: Int, tiles: Int, marks: Bytes, scratch: Numbers) -> None:
    """Write the numbers of a tile's neighbours to scratch memory, and which of them, and itself, have been visited."""
    column = tile % across
    at_left, at_right = column == 0, column == across - 1
    at_top, at_bottom = tile < across, tile + across >= tiles
    _set_neighbour(TOP, at_top, tile - across, tiles, marks, scratch)
    _set_neighbour(BOTTOM, at_bottom, tile + across, tiles, marks, scratch)
    _set_neighbour(LEFT, at_left, tile - 1, tiles, marks, scratch)
    _set_neighbour(RIGHT, at_right, tile + 1, tiles, marks, scratch)
    _set_neighbour(TOP_LEFT, at_top or at_left, tile - across - 1, tiles, marks, scratch)
    _set_neighbour(TOP_RIGHT, at_top or at_right, tile - across + 1, tiles, marks, scratch)
    _set_neighbour(BOTTOM_LEFT, at_bottom or at_left, tile + across - 1, tiles, marks, scratch)
    _set_neighbour(BOTTOM_RIGHT, at_bottom or at_right, tile + across + 1, tiles, marks, scratch)
    scratch[SEEN + SELF] = tile if marks[tile] & TOUCHED else tiles


@joined
def _set_neighbour(move: Int, is_outside: bool, other: Int, tiles: Int, marks: Bytes, scratch: Numbers) -> None:
    neighbour = tiles if is_outside else other
    scratch[BESIDE + move] = neighbour
    scratch[SEEN + move] = neighbour if atomics.read(marks, neighbour) & TOUCHED else tiles


@joined
def beside(scratch: Numbers, move: Int) -> Int:
    """Return the neighbour of the current tile on one side or at one corner."""
    number: Int = simd.pick(scratch, BESIDE + move)
    return number


@joined
def seen(scratch: Numbers, move: Int) -> Int:
    """Return the tile whose values to read: the neighbour, or the current tile (`SELF`); if unvisited, the outside."""
    number: Int = simd.pick(scratch, SEEN + move)
    return number


@joined
def edge(tables: Numbers, tile: Int, side: Int) -> Any:
    """Return the values of the cells of a tile along one of its sides."""
    return simd.load(tables, tile * TABLE + EDGES + side * SIDE)


@joined
def free_along(tables: Numbers, tile: Int, side: Int) -> Int:
    """Return the free cells of a tile along one of its sides, as lanes."""
    line = COLUMNS + (side & 1) if side in (LEFT, RIGHT) else FREE + (LAST if side == BOTTOM else 0)
    number: Int = simd.pick(tables, tile * TABLE + line)
    return number


@bare
def _weights_along(tables: Numbers, costs: Bytes, tile: Int, side: Int, scratch: Numbers) -> Any:
    """Return the weights of the cells of a tile along one of its sides."""
    first = tile * CELLS + (LAST * SIDE if side == BOTTOM else LAST if side == RIGHT else 0)
    if tables[tile * TABLE + KIND] != MIXED:
        return weighed(simd.splat(np.int64(tables[tile * TABLE + COST])))
    if side in (TOP, BOTTOM):
        return weighed(simd.load_bytes(costs, first))
    for row in range(SIDE):
        simd.put(scratch, SPARE + row, np.int64(costs[first + row * SIDE]))
    return weighed(simd.load(scratch, SPARE))


@bare
def crossed(
    tables: Numbers, costs: Bytes, tile: Int, side: Int, values: Any, near: Int, before: Any, scratch: Numbers
) -> Any:
    """Return the values of the cells of a tile along one of its sides after all moves from the cells beside it.

    Parameters
    ----------
    tables, costs, tile, side, scratch
        The tile that is entered, and its side.
    values : row
        Values of the cells beside it.
    near : lanes
        The free ones of those.
    before : row
        Values of its own cells along that side.
    """
    free = free_along(tables, tile, side)
    weights, both = _weights_along(tables, costs, tile, side, scratch), free & near
    return relaxed(values, before, free, both & (free << 1), both & (free >> 1), weights, slanted(weights))


@bare
def wake_side(tables: Numbers, costs: Bytes, tile: Int, side: Int, values: Any, scratch: Numbers) -> Int:
    """Return the least value that the current tile improves in the neighbour on a side; `UNREACHED` if none."""
    other, facing = beside(scratch, side), side ^ 1
    before = edge(tables, seen(scratch, side), facing)
    after = crossed(tables, costs, other, facing, values, free_along(tables, tile, side), before, scratch)
    better = simd.less(after, before)
    return simd.least_of(simd.where(better, after, simd.splat(UNREACHED))) if better else UNREACHED


@bare
def _is_passable(tables: Numbers, move: Int, scratch: Numbers) -> bool:
    """Return whether both cells beside a diagonal move over a corner of the current tile are free."""
    down, right = move in (BOTTOM_LEFT, BOTTOM_RIGHT), move in (TOP_RIGHT, BOTTOM_RIGHT)
    above, aside = beside(scratch, BOTTOM if down else TOP), beside(scratch, RIGHT if right else LEFT)
    column, row = (LAST if right else 0), (LAST if down else 0)
    vertical = free_along(tables, above, TOP if down else BOTTOM) >> column
    horizontal = free_along(tables, aside, LEFT if right else RIGHT) >> row
    return bool((vertical & horizontal & 1) != 0)


@bare
def over_corner(tables: Numbers, costs: Bytes, tile: Int, move: Int, into: bool, scratch: Numbers) -> Int:
    """Return the value of the cell that a diagonal move over a corner of the current tile enters.

    Parameters
    ----------
    tables, costs, tile, scratch
        The current tile.
    move : int
        The corner.
    into : bool
        Whether the move leads into the tile, not out of it.

    Returns
    -------
    int
        `UNREACHED` if the move is blocked or improves nothing.
    """
    other = beside(scratch, move)
    source, target, back = (move, tile, move) if into else (SELF, other, move ^ 3)
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
    value = value_at(tables, seen(scratch, source), back ^ 3) + ((weight * ROOT + HALF) >> ROOT_SHIFT)
    return value if value < value_at(tables, seen(scratch, SELF if into else move), back) else UNREACHED


@joined
def value_at(tables: Numbers, tile: Int, move: Int) -> Int:
    """Return the value of the corner cell of a tile."""
    side = BOTTOM if move in (BOTTOM_LEFT, BOTTOM_RIGHT) else TOP
    lane = LAST if move in (TOP_RIGHT, BOTTOM_RIGHT) else 0
    number: Int = simd.pick(tables, tile * TABLE + EDGES + side * SIDE + lane)
    return number


@joined
def too_long(values: Any) -> bool:
    """Return whether a value of a line exceeds `LIMIT`, so that later ones might not fit 32 bits."""
    return bool(simd.less(simd.splat(LIMIT), values) & simd.less(values, simd.splat(UNREACHED)))
