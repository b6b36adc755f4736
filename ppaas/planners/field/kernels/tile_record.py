"""Kernel parts: what is told of a field of tiles in one array of numbers, among them where its other arrays lie.

To call a kernel with a dozen arrays takes as long as a tile; and a helper without Python can be told only numbers.

Of the map: `HEIGHT`, `WIDTH`, `UNKNOWN`, and at `SOURCE` its costs, as in `tile_setup`. Of the field: how many tiles it
has `ACROSS`, and how many `TILES` in all; at `TARGET` the element whose value is wanted, −1 to go on until all are
reached; and of each of these arrays the address, followed by its length:

- `FIELD`, `TABLES`, `COSTS`: as in `tile_layout`.
- `MARKS`: (tiles + 1) uint8, for each tile whether somebody has been there, and whether its table is filled.
- `WORDS`, `HINTS`, `PLACES`: as in `ppaas.planners.field.kernels.tile_queue`.
- `SCRATCH_MEMORY`: (threads · `SCRATCH`) uint32, a part for each thread that may ever work at this field.
- `STATE`: as in `ppaas.planners.field.kernels.tile_state`.

Whoever calls a kernel with it holds the arrays until the last helper has left.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.kernels.addresses import address_of
from ppaas.planners.kernels.jit_decorators import bare

HEIGHT, WIDTH, UNKNOWN, ACROSS, TILES, TARGET = range(6)
SOURCE, FIELD, TABLES, COSTS, MARKS, WORDS, HINTS, PLACES, SCRATCH_MEMORY, STATE = range(6, 26, 2)
RECORD = 26
"""Numbers of a record."""


@bare
def note(record: NDArray[np.int64], place: int, array: NDArray[Any]) -> None:
    """Write into a record where an array lies."""
    record[place], record[place + 1] = address_of(array), len(array)


def warm() -> None:
    """Compile and call the kernel once for each kind of array."""
    record, read_only = np.zeros(RECORD, np.int64), np.zeros(1, np.uint8)
    read_only.flags.writeable = False
    for array in (record, read_only, np.zeros(1, np.uint8), np.zeros(1, np.uint32)):
        note(record, SOURCE, array)
