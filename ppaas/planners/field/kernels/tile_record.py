"""Kernel parts: record of a tile field, one int64 array with its parameters and the addresses of its arrays.

Passing a dozen arrays to a kernel takes as long as processing a tile, and a helper thread without Python can only be
given numbers.

Parameters of the map: `HEIGHT`, `WIDTH`, `UNKNOWN` as in `tile_setup`. Parameters of the field: `ACROSS`, the number of
tiles in a row; `TILES`, their number in total; `TARGET`, the element whose value is wanted, or −1 to reach all. Each
array is its address followed by its length:

- `SOURCE`: (height · width) uint8, the costs of the map, read-only.
- `FIELD`, `TABLES`, `COSTS`: as in `tile_layout` and `tile_setup`.
- `MARKS`: (tiles + 1) uint8, for each tile whether it has been visited, and whether its table is filled.
- `WORDS`, `HINTS`, `PLACES`: as in `ppaas.planners.field.kernels.tile_queue`.
- `SCRATCH_MEMORY`: (threads · `SCRATCH`) uint32, a part for each thread of this field.
- `STATE`: as in `ppaas.planners.field.kernels.tile_state`.

The caller of a kernel must hold the arrays until the last helper has left.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare
from ppaas.planners.kernels.addresses import address_of

HEIGHT, WIDTH, UNKNOWN, ACROSS, TILES, TARGET = range(6)
SOURCE, FIELD, TABLES, COSTS, MARKS, WORDS, HINTS, PLACES, SCRATCH_MEMORY, STATE = range(6, 26, 2)
RECORD = 26
"""Length of a record [int64 numbers]."""


@bare
def store_array(record: NDArray[np.int64], place: int, array: NDArray[Any]) -> None:
    """Write address and length of an array into a record."""
    record[place], record[place + 1] = address_of(array), len(array)


def warm() -> None:
    """Compile and call the kernel once for each kind of array."""
    record, read_only = np.zeros(RECORD, np.int64), np.zeros(1, np.uint8)
    read_only.flags.writeable = False
    for array in (record, read_only, np.zeros(1, np.uint8), np.zeros(1, np.uint32)):
        store_array(record, SOURCE, array)
