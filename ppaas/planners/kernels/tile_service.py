"""Kernel: help with fields of tiles, one after another, without Python."""

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.kernels.addresses import longs_at, map_at, numbers_at, octets_at
from ppaas.planners.kernels.bare import bare
from ppaas.planners.kernels.tile_growth import grow_tiles
from ppaas.planners.kernels.tile_help import (
    ACROSS,
    BOX,
    COSTS,
    FIELD,
    HEIGHT,
    HINTS,
    MARKS,
    OVER,
    PLACES,
    SCRATCH_MEMORY,
    SOURCE,
    STATE,
    TABLES,
    TARGET,
    THREAD,
    TILES,
    UNKNOWN,
    WIDTH,
    WORDS,
    comes,
    leave,
)

Ints = NDArray[np.int64]

ENDLESS = 1 << 62
"""Lines of tiles: a helper is told when to stop."""


@bare
def serve(box: Ints, nobody: Ints) -> None:
    """Come whenever called, until it is over.

    Parameters
    ----------
    box : (BOX,) int64 array
        As in `ppaas.planners.kernels.tile_help`.
    nobody : (0, BOX) int64 array
        The boxes of those whom a helper may call.
    """
    while comes(box):
        grow_tiles(
            map_at(box[SOURCE], box[SOURCE + 1]), box[HEIGHT], box[WIDTH], box[UNKNOWN],
            numbers_at(box[FIELD], box[FIELD + 1]),
            numbers_at(box[TABLES], box[TABLES + 1]),
            octets_at(box[COSTS], box[COSTS + 1]),
            box[ACROSS], box[TILES],
            octets_at(box[MARKS], box[MARKS + 1]),
            numbers_at(box[WORDS], box[WORDS + 1]),
            numbers_at(box[HINTS], box[HINTS + 1]),
            numbers_at(box[PLACES], box[PLACES + 1]),
            numbers_at(box[SCRATCH_MEMORY], box[SCRATCH_MEMORY + 1]),
            longs_at(box[STATE], box[STATE + 1]),
            box[TARGET], nobody, box[THREAD], ENDLESS,
        )  # fmt: skip
        leave(box)


def warm() -> None:
    """Compile and call each kernel once."""
    box = np.zeros(BOX, np.int64)
    box[OVER] = 1
    serve(box, np.zeros((0, BOX), np.int64))
