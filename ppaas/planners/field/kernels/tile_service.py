"""Kernel: help with fields of tiles, one after another, without Python."""

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.field.kernels.tile_growth import grow_tiles
from ppaas.planners.field.kernels.tile_help import BOX, FIELD_RECORD, OVER, THREAD, comes, leave
from ppaas.planners.kernels.addresses import longs_of
from ppaas.planners.kernels.jit_decorators import bare

Ints = NDArray[np.int64]

ENDLESS = 1 << 62
"""Lines of tiles: a helper is told when to stop."""


@bare
def serve(box: Ints, nobody: Ints) -> None:
    """Come whenever called, until it is over.

    Parameters
    ----------
    box : (BOX,) int64 array
        As in `ppaas.planners.field.kernels.tile_help`.
    nobody : (0, BOX) int64 array
        The boxes of those whom a helper may call.
    """
    while comes(box):
        grow_tiles(longs_of(box, FIELD_RECORD), nobody, box[THREAD], ENDLESS)
        leave(box)


def warm() -> None:
    """Compile and call each kernel once."""
    box = np.zeros(BOX, np.int64)
    box[OVER] = 1
    serve(box, np.zeros((0, BOX), np.int64))
