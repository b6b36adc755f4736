"""Layout of tiles, for the kernels that share them.

A tile is 32×32 cells, so that one row of it is one row of `ppaas.planners.kernels.simd`. Tiles are numbered row by row;
those at the far edges of the map are padded with blocked cells. One additional tile stands for everything outside. The
field stores tile after tile: cell (r, c) of tile t is element 1024·t + 32·r + c, its cost-to-go in fixed point, or
`UNREACHED`, also for blocked cells.

"Top" means the first row: a tile's neighbour at the top holds the rows before its own.

Each tile has an entry of `TABLE` numbers in ``tables``:

- `EDGES`: values of its top row, bottom row, left column and right column, 32 each, valid once the tile has been
  visited. Neighbours read only these; only the thread that works on the tile writes them.
- `FREE`: bit sets of its free cells: one number per row, then one each for the left and the right column; the lowest
  bit is the first cell.
- `KIND`: one of `BLOCKED`, `OPEN`, `WALLED`, `MIXED`. `COST`: the cost of its free cells, if they all have the same.
"""

import numpy as np

from ppaas.planners.weights import fixed_weights

SIDE = 32
CELLS = SIDE * SIDE
CELL_SHIFT = 10

UNREACHED = 0xFF000000
"""Value of unreached cells. It is 16 million below 2³², so that weights added to it within a tile do not overflow."""

LIMIT = UNREACHED - (1 << 26)
"""Bound of the values at the edges of tiles. Below it, values within a tile cannot overflow: a path through all its
1024 cells weighs less than 2²⁵."""

TOP, BOTTOM, LEFT, RIGHT, TOP_LEFT, TOP_RIGHT, BOTTOM_LEFT, BOTTOM_RIGHT = (np.int64(move) for move in range(8))
"""Neighbours of a tile, and numbers of the bits that record which of them woke it. They are numpy integers, because
numba would compile a specialization for each literal Python integer."""
GOAL = 8
"""Number of the bit of a tile that was woken because it contains a goal."""

TOUCHED, FILLED = 1, 2
"""Marks of a tile: it has been visited; its table is filled."""

EDGES = 0
FREE = 4 * SIDE
COLUMNS = FREE + SIDE
KIND = COLUMNS + 2
COST = KIND + 1
TABLE = 176

BLOCKED, OPEN, WALLED, MIXED = range(4)
"""Kinds of tiles: no free cell; all cells free, at one cost; some cells free, at one cost; free cells of several
costs."""

ALL = 0xFFFFFFFF
"""The set of all 32 lanes."""

BASE, FACTOR, UNKNOWN = (int(fixed_weights()[0, cost]) for cost in (0, 1, 255))
FACTOR -= BASE
"""Weights in fixed point: BASE + FACTOR·cost for a known cell, UNKNOWN for an unknown one."""

ROOT, HALF, ROOT_SHIFT = 46_341, 1 << 14, 15
"""A diagonal move weighs (w·ROOT + HALF) >> ROOT_SHIFT, which equals w·√2 rounded for all possible weights w."""

LETHAL = np.uint8(254)
