"""Kernel: main loop of a helper thread of tile fields, without Python."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare
from ppaas.planners.field.kernels.tile_growth import grow_tiles
from ppaas.planners.field.kernels.tile_help import BOX, FIELD_RECORD, OVER, THREAD, finish, wait_for_call
from ppaas.planners.kernels.addresses import int64s_of

Ints = NDArray[np.int64]

ENDLESS = 1 << 62
"""Budget of a helper, which runs until it is asked to stop."""


@bare
def serve(box: Ints, nobody: Ints) -> None:
    """Wait for calls and help with each, until the process exits.

    Parameters
    ----------
    box : (BOX,) int64 array
        Mailbox, as in `ppaas.planners.field.kernels.tile_help`.
    nobody : (0, BOX) int64 array
        The helpers that a helper may call: none.
    """
    while wait_for_call(box):
        grow_tiles(int64s_of(box, FIELD_RECORD), nobody, box[THREAD], ENDLESS)
        finish(box)


def warm() -> None:
    """Compile and call each kernel once."""
    box = np.zeros(BOX, np.int64)
    box[OVER] = 1
    serve(box, np.zeros((0, BOX), np.int64))
