"""Tiles that are filled as a group have the same tables as single tiles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.kernel_cache.decorators import bare
from ppaas.planners.field.kernels.tile_groups import FEW, MANY, fill_around
from ppaas.planners.field.kernels.tile_layout import (
    ALL,
    BLOCKED,
    CELLS,
    COLUMNS,
    COST,
    FILLED,
    FREE,
    KIND,
    MIXED,
    OPEN,
    SIDE,
    TABLE,
    WALLED,
)  # fmt: skip
from ppaas.planners.field.kernels.tile_rows import SCRATCH

COSTS_OF_TILES = (0, 0, 0, 7, 252, 253, 254, 255)


@bare
def fill_one(source, height, width, unknown, across, tiles, tile, costs, tables, marks, scratch, is_far):
    fill_around(source, height, width, unknown, across, tiles, tile, costs, tables, marks, scratch, is_far)


def fill(map_, tile, allow_unknown, is_far):
    """Return the marks, the tables and the copied costs after a visit to one tile."""
    source = map_.reshape(-1)
    source.flags.writeable = False
    across = -(-map_.shape[1] // SIDE)
    tiles = -(-map_.shape[0] // SIDE) * across
    costs, tables = np.zeros(tiles * CELLS, np.uint8), np.zeros((tiles + 1) * TABLE, np.uint32)
    marks, scratch = np.zeros(tiles + 1, np.uint8), np.full(SCRATCH, 0xABCDEF, np.uint32)
    fill_one(source, *map_.shape, ALL * allow_unknown, across, tiles, tile, costs, tables, marks, scratch, is_far)
    return marks[:tiles], tables.reshape(-1, TABLE), costs.reshape(-1, SIDE, SIDE)


def described(map_, tile, allow_unknown):
    """Return the expected table of a tile, computed cell by cell: its cells, the free ones, the kind, and the cost."""
    across = -(-map_.shape[1] // SIDE)
    top, left = tile // across * SIDE, tile % across * SIDE
    cells = np.full((SIDE, SIDE), 254, np.uint8)
    part = map_[top : top + SIDE, left : left + SIDE]
    cells[: part.shape[0], : part.shape[1]] = part
    free = (cells < 253) | ((cells == 255) & allow_unknown)
    costs = set(cells[free].tolist())
    kind = MIXED if len(costs) > 1 else OPEN if free.all() else WALLED if costs else BLOCKED
    return cells, free, kind, costs


def bits(row):
    return sum(1 << place for place, value in enumerate(row) if value)


def check(map_, tile, allow_unknown=True, is_far=True):
    marks, tables, costs = fill(map_, tile, allow_unknown, is_far)
    for other in np.flatnonzero(marks & FILLED):
        cells, free, kind, found = described(map_, other, allow_unknown)
        assert tables[other, FREE : FREE + SIDE].tolist() == [bits(row) for row in free]
        assert tables[other, COLUMNS : COLUMNS + 2].tolist() == [bits(free[:, 0]), bits(free[:, -1])]
        assert tables[other, KIND] == kind
        if kind == MIXED:
            assert (costs[other] == cells).all()
        else:
            assert [tables[other, COST]] == (list(found) or [0])
    return marks & FILLED != 0


@st.composite
def maps(draw):
    """Draw maps whose tiles often have one cost, except for a cell or two."""
    height, width = draw(st.integers(1, 100)), draw(st.integers(1, 1_200))
    across, down = -(-width // SIDE), -(-height // SIDE)
    rng = np.random.default_rng(draw(st.integers(0, 1 << 32)))
    map_ = np.kron(rng.choice(COSTS_OF_TILES, (down, across)), np.ones((SIDE, SIDE)))[:height, :width].astype(np.uint8)
    for _ in range(draw(st.integers(0, 2 * across))):
        map_[rng.integers(height), rng.integers(width)] = rng.choice(COSTS_OF_TILES)
    return map_, int(rng.integers(across * down))


@given(maps(), st.booleans(), st.booleans())
def test_a_group_has_the_same_tables_as_single_tiles(drawn, allow_unknown, is_far):
    check(*drawn, allow_unknown, is_far)


@pytest.mark.parametrize("column", range(SIDE))
def test_a_single_different_cell_is_detected_in_any_column(column):
    map_ = np.zeros((SIDE, FEW * SIDE), np.uint8)
    for tile in range(FEW):
        map_[(column * 7 + tile * 5) % SIDE, tile * SIDE + (column + tile) % SIDE] = 254 - tile % 2 * 100
    check(map_, 0)


@pytest.mark.parametrize(
    ("across", "is_far", "group"),
    [(FEW - 1, True, FEW), (3 * FEW, True, FEW), (MANY, False, FEW), (MANY, True, MANY), (2 * MANY + 3, True, MANY)],
)
def test_the_neighbours_and_their_groups_are_filled(across, is_far, group):
    map_ = np.zeros((5 * SIDE, across * SIDE - 1), np.uint8)
    for tile in (0, across + group % across, 2 * across - 1, 4 * across):
        row, column = divmod(tile, across)
        of_rows, of_groups = abs(np.arange(5) - row) <= 1, np.zeros(across, bool)
        for beside in range(max(column - 1, 0), min(column + 2, across)):
            of_groups[beside // group * group : beside // group * group + group] = True
        assert (check(map_, tile, is_far=is_far).reshape(5, across) == of_rows[:, None] & of_groups).all()
