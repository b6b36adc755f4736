"""How a map is cut into tiles, for the kernels that share them.

A tile is 32×32 cells, so that one row of it is one row of `ppaas.planners.kernels.simd`. Tiles are numbered row by row;
those at the far edges of the map are filled up with blocked cells. One more stands for all that is outside. The field
holds one tile after the other: cell (r, c) of tile t is element 1024·t + 32·r + c, its cost-to-go in fixed point, or
`UNREACHED`, which blocked cells have too.

Rows are drawn here with the first on top: a tile's neighbour at the top holds the rows before its own.

Each tile has an entry in ``tables``, `TABLE` numbers long:

- `EDGES`: the values of its top row, bottom row, left column and right column, 32 each, once somebody has been there.
  Its neighbours read these alone; only the thread that works on the tile writes them.
- `FREE`: which cells are free, one number a row, then one for the left and one for the right column, the lowest bit for
  the first.
- `KIND`: how its cells weigh. `COST`: what its free cells cost, if all the same.
"""

import numpy as np

from ppaas.planners.weights import fixed_weights

SIDE = 32
CELLS = SIDE * SIDE
CELL_SHIFT = 10

UNREACHED = 0xFF000000
"""Sixteen million below the most there is: what is added to it within a tile does not wrap around."""

LIMIT = UNREACHED - (1 << 26)
"""As long as no value at the edge of a tile is above, none within is cut off: a path through all 1024 cells of a tile
weighs less than 2²⁵."""

TOP, BOTTOM, LEFT, RIGHT, TOP_LEFT, TOP_RIGHT, BOTTOM_LEFT, BOTTOM_RIGHT = (np.int64(move) for move in range(8))
"""The neighbours of a tile, and the bits that tell which of them woke it. Of Python's numbers numba would compile what
they are given to once for each."""
GOAL = 8
"""Bit of a tile that is woken because a goal lies in it."""

TOUCHED, LAID = 1, 2
"""Marks of a tile: somebody has been there; its table is filled."""

EDGES = 0
FREE = 4 * SIDE
COLUMNS = FREE + SIDE
KIND = COLUMNS + 2
COST = KIND + 1
TABLE = 176

BLOCKED, OPEN, WALLED, MIXED = range(4)
"""Kinds: no cell is free; all are, at one cost; some are, at one cost; costs differ."""

ALL = 0xFFFFFFFF
"""The set of all lanes."""

BASE, FACTOR, UNKNOWN = (int(fixed_weights()[0, cost]) for cost in (0, 1, 255))
FACTOR -= BASE
"""In fixed point a cell weighs BASE + FACTOR·cost, an unknown one UNKNOWN."""

ROOT, HALF, ROOT_SHIFT = 46_341, 1 << 14, 15
"""A diagonal weighs (w·ROOT + HALF) >> ROOT_SHIFT, which for all weights there are is w·√2 rounded."""

LETHAL = np.uint8(254)
