"""Cost field in space: the cost of the cheapest path from each voxel to the nearest goal.

The value of a voxel is the minimum, over its 26 neighbours n, of value(n) + w(voxel)·(1, √2 or √3), and 0 at a goal. A
diagonal move needs all voxels free in the 2×2 square or 2×2×2 cube that it crosses. Weights come from
`ppaas.planners.weights`. The field is exact in fixed point, and identical for any slicing of the work.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.voxels import VoxelCostmap
from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidInput, NoValidPath
from ppaas.maps.voxels import Voxel, only_read
from ppaas.planners.kernels.moves import PAUSED, POOL_EMPTY, SETTLED
from ppaas.planners.volume.kernels.descent import descend
from ppaas.planners.volume.kernels.layout import AT_GOAL, BLOCKED, BUCKET_SHIFT, CHUNK, MAX_CHUNKS, RING, UNREACHED
from ppaas.planners.volume.kernels.propagation import (
    BUCKET,
    COUNT,
    FREE,
    SPARE,
    STATE_SIZE,
    TOO_LONG,
    least_left,
    propagate,
)
from ppaas.planners.volume.kernels.setup import pad_layers
from ppaas.planners.watch import proceed
from ppaas.planners.weights import NEUTRAL, SCALE, fixed_weights, passable

SLICE_VOXELS = 10_000
"""Voxels expanded between two checks: about 2 ms."""
SLICE_WALKED = 20_000
"""Voxels of a path written between two checks."""
SLICE_SETUP = 1 << 20
"""Voxels set up between two checks."""


class _VoxelBucketQueue:
    """Ring of buckets, each a linked list of chunks from one pool.

    Parameters
    ----------
    voxels : (n,) uint32 array
        Initial contents.
    bucket : int
        Number of the bucket that holds all of them, the lowest one.
    """

    def __init__(self, voxels: NDArray[np.uint32], bucket: int) -> None:
        taken = -(-len(voxels) // CHUNK)
        chunks = taken + 2 * MAX_CHUNKS
        self.pool = np.empty((chunks, CHUNK), np.uint32)
        self.pool.ravel()[: len(voxels)] = voxels
        self.links = np.arange(1, chunks + 1, dtype=np.int32)
        self.links[:taken] = np.arange(-1, taken - 1)
        self.links[-1] = -1
        self.heads = np.full(RING, -1, np.int32)
        self.fills = np.full(RING, CHUNK, np.int32)
        slot = bucket & (RING - 1)
        self.heads[slot] = taken - 1
        self.fills[slot] = len(voxels) - (taken - 1) * CHUNK
        self.state = np.zeros(STATE_SIZE, np.int64)
        self.state[BUCKET], self.state[FREE], self.state[SPARE] = bucket, taken, chunks - taken

    @property
    def expanded(self) -> int:
        """Number of expansions; a voxel expanded twice counts twice."""
        return int(self.state[COUNT])

    def grow(self) -> None:
        """Enlarge the pool by half; the queued voxels remain in it."""
        chunks = len(self.pool)
        more = chunks // 2
        self.pool = np.concatenate((self.pool, np.empty((more, CHUNK), np.uint32)))
        added = np.arange(chunks + 1, chunks + more + 1, dtype=np.int32)
        added[-1] = self.state[FREE]
        self.links = np.concatenate((self.links, added))
        self.state[FREE] = chunks
        self.state[SPARE] += more


class VoxelField:
    """Cost field that grows from its goals in slices, outward or towards one voxel.

    It uses five bytes per voxel, and the queue four per queued voxel.

    Parameters
    ----------
    costmap : VoxelCostmap
        Only read.
    goals : (n, 3) array
        Layer, row, column of free voxels on the map.
    target : (layer, row, column), optional
        The only voxel whose value is wanted: the field then grows towards it (A*). Requires a single goal.
    allow_unknown : bool
        Whether unknown voxels may be entered.
    check : callable
        Called at least every few milliseconds of work; an exception from it ends the work.

    Raises
    ------
    InvalidInput
        ``goals`` is empty or not an (n, 3) array, or there are a target and several goals.
    GoalOutsideMap, GoalOccupied
    """

    def __init__(
        self,
        costmap: VoxelCostmap,
        goals: NDArray[np.integer],
        *,
        target: Voxel | None = None,
        allow_unknown: bool = True,
        check: Callable[[], None] = proceed,
    ) -> None:
        _check_goals(costmap, goals, target, allow_unknown)
        self._check = check
        depth, height, width = costmap.info.shape
        self._shape = depth + 2, height + 2, width + 2
        self._weights = _fixed_weights_3d()
        self._costs, self._field = self._padded(costmap, passable(allow_unknown))
        self._aim = target
        self._least = self._weights[:, 0].copy() if target is not None else np.zeros(3, np.int64)
        padded = np.asarray(goals, np.int64) + 1
        flat = np.unique((padded[:, 0] * self._shape[1] + padded[:, 1]) * self._shape[2] + padded[:, 2])
        self._field[flat] = AT_GOAL
        layers, rows, columns = np.subtract(goals[0], target).tolist() if target is not None else (0, 0, 0)
        bucket = (AT_GOAL + int(least_left(layers, rows, columns, self._least))) >> BUCKET_SHIFT
        self._queue = _VoxelBucketQueue(flat.astype(np.uint32), bucket)

    @property
    def settled(self) -> int:
        """Number of expanded voxels; with a target some count twice."""
        return self._queue.expanded

    def grow(self, target: Voxel | None = None) -> bool:
        """Grow the field until the value of ``target`` is final, or over the whole map.

        If the constructor was given a target, that one is used.

        Returns
        -------
        bool
            Whether the target can be reached; true without a target.

        Raises
        ------
        NoValidPath
            Path costs exceed 32 bits: more than a million free voxels.
        """
        wanted = self._aim if self._aim is not None else target
        flat = -1 if wanted is None else self._flat(wanted)
        plane = self._shape[1] * self._shape[2]
        while True:
            self._check()
            q = self._queue
            outcome = propagate(
                self._field, self._costs, self._shape[2], plane, self._weights, self._least,
                q.pool, q.links, q.heads, q.fills, q.state, flat, SLICE_VOXELS,
            )  # fmt: skip
            if outcome == POOL_EMPTY:
                q.grow()
            elif outcome == TOO_LONG:
                raise NoValidPath(
                    "the path is longer than a million free voxels; plan at a coarser depth of the octomap"
                )
            elif outcome != PAUSED:
                return bool(outcome == SETTLED or wanted is None or self._field[flat] < UNREACHED)

    def path_from(self, voxel: Voxel) -> NDArray[np.int32]:
        """Return the (n, 3) voxels of a cheapest path from ``voxel``, whose value must be final, to a goal."""
        most = (int(self._field[self._flat(voxel)]) - AT_GOAL) // round(SCALE * NEUTRAL) + 1
        cells = np.empty((most, 3), np.int32)
        cells[0] = voxel
        count, before = 1, 0
        while count > before:
            self._check()
            before = count
            count = descend(
                self._field, self._costs, self._shape[2], self._shape[1] * self._shape[2], self._weights,
                cells, count, min(SLICE_WALKED, most - count),
            )  # fmt: skip
        return cells[:count].copy()

    def values(self) -> NDArray[np.float64]:
        """Return the (depth, height, width) costs-to-go; infinite if blocked or not reached."""
        inner = self._field.reshape(self._shape)[1:-1, 1:-1, 1:-1]
        reached = (inner != BLOCKED) & (inner != UNREACHED)
        return np.where(reached, (inner.astype(np.float64) - AT_GOAL) / SCALE, np.inf)

    def _flat(self, voxel: Voxel) -> int:
        layer, row, column = voxel
        return ((layer + 1) * self._shape[1] + row + 1) * self._shape[2] + column + 1

    def _padded(
        self, costmap: VoxelCostmap, open_costs: NDArray[np.bool_]
    ) -> tuple[NDArray[np.uint8], NDArray[np.uint32]]:
        costs, field = np.empty(self._shape, np.uint8), np.empty(self._shape, np.uint32)
        source = only_read(costmap.data)
        layers = max(1, SLICE_SETUP // (self._shape[1] * self._shape[2]))
        for first in range(0, self._shape[0], layers):
            self._check()
            pad_layers(source, open_costs, costs, field, first, min(first + layers, self._shape[0]))
        return costs.ravel(), field.ravel()


def _check_goals(costmap: VoxelCostmap, goals: NDArray[np.integer], target: Voxel | None, allow_unknown: bool) -> None:
    if goals.ndim != 2 or goals.shape[1:] != (3,) or not len(goals):
        raise InvalidInput(f"goals must be one or more rows of layer, row, column, not an array of shape {goals.shape}")
    if target is not None and len(goals) > 1:
        raise InvalidInput(f"a field with a target takes one goal, not {len(goals)}")
    outside = (goals < 0).any(axis=1) | (goals >= costmap.info.shape).any(axis=1)
    if outside.any():
        raise GoalOutsideMap(
            f"the goal in voxel {goals[outside][0].tolist()} is outside the map, whose shape is {costmap.info.shape}"
        )
    blocked = ~passable(allow_unknown)[costmap.data[tuple(goals.T)]]
    if blocked.any():
        raise GoalOccupied(f"the goal in voxel {goals[blocked][0].tolist()} is blocked; choose a free voxel")


def _fixed_weights_3d() -> NDArray[np.int64]:
    """Return the (3, 256) weights of moves along one, two and three axes in fixed point; that of 254 is 0.

    The √3 diagonal is rounded to the nearest unit like the √2 one, and weighs more, so `RELATIVE_ERROR` of
    `ppaas.planners.weights` also bounds its relative error.
    """
    flat = fixed_weights()
    return np.vstack((flat, np.rint(flat[0] * math.sqrt(3.0)).astype(np.int64)))
