"""Maps and tile fields for tests."""

from functools import partial

import numpy as np

from ppaas.planners.field.kernels import tile_layout
from ppaas.planners.field.kernels.tile_growth import grow_tiles
from ppaas.planners.field.kernels.tile_help import BOX, FIELD_RECORD
from ppaas.planners.field.queue_field import QueueField
from ppaas.planners.field.tile_field import TileField
from ppaas.planners.field.tile_helpers import boxes_for
from tests.support.world import grids

MANY = 8
"""Threads of a field in tests of concurrency."""

NOBODY = np.zeros((0, BOX), np.int64)
"""No helpers."""

KINDS = ["empty", "graded", "cluttered", "patches", "maze"]
"""Kinds of maps that `drawn` knows."""


def drawn(kind, shape, seed):
    """Draw a map with tiles of all kinds."""
    rng = np.random.default_rng(seed)
    costs = np.zeros(shape, np.uint8)
    if kind == "graded":
        costs = rng.integers(0, 256, shape).astype(np.uint8)
    if kind == "patches":
        patches = rng.choice([0, 0, 7, 200, 252, 254, 255], (shape[0] // 24 + 1, shape[1] // 40 + 1))
        costs = np.kron(patches, np.ones((24, 40)))[: shape[0], : shape[1]].astype(np.uint8)
    if kind == "cluttered":
        costs[rng.random(shape) < 0.05 * (1 + seed % 8)] = 254
    if kind == "maze":
        costs[1::2, 1::2] = 254
        to_east = rng.random(costs[::2, ::2].shape) < 0.5
        costs[::2, 1::2][to_east[:, : costs[::2, 1::2].shape[1]]] = 254
        costs[1::2, ::2][~to_east[: costs[1::2, ::2].shape[0]]] = 254
    return costs


def fields(costs, goals, allow_unknown=True, threads=1):
    """Return a field by tiles and one by a queue, on the same map and goals."""
    goals = np.array(goals)
    tiled = TileField(grids.of(costs), goals, allow_unknown=allow_unknown, threads=threads)
    return tiled, QueueField(grids.of(costs), goals, allow_unknown=allow_unknown)


def worker(field):
    """Return the kernel of a field without helpers, as a function of thread number and budget."""
    field._memory.open_for_help(-1)
    return partial(grow_tiles, field._memory.record, NOBODY)


def helps(number, field):
    """Return whether a helper, by its number, has been called to a field."""
    return boxes_for(number + 1)[number - 1, FIELD_RECORD] == field._memory.record.ctypes.data


def filled_tables(field):
    """Return the number of tiles whose tables are filled."""
    return np.count_nonzero(field._memory.marks[: field._tiles] & tile_layout.FILLED)
