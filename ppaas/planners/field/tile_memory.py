"""Arrays of a tile field, reused by the next field: page faults of new memory cost as much time as the field itself."""

import os
import weakref
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.field.kernels.tile_help import release_helpers, wait_briefly
from ppaas.planners.field.kernels.tile_layout import ALL, CELLS, TABLE
from ppaas.planners.field.kernels.tile_queue import GROUP, deal_groups, part_size
from ppaas.planners.field.kernels.tile_record import (
    COSTS,
    FIELD,
    HINTS,
    MARKS,
    PLACES,
    RECORD,
    SCRATCH_MEMORY,
    SOURCE,
    STATE,
    TABLES,
    TARGET,
    WORDS,
    store_array,
)
from ppaas.planners.field.kernels.tile_rows import SCRATCH
from ppaas.planners.field.kernels.tile_state import ALIGNED, APART, CALLED, STOP, THREADS, state_size

T = TypeVar("T", bound=np.generic)

MAX_OVERSIZE = 4
"""Arrays larger than needed by more than this factor are not reused."""


class TileMemory:
    """Arrays of one tile field at a time; `ppaas.planners.field.kernels.tile_record` describes their contents.

    Parameters
    ----------
    tiles : int
        Capacity [tiles], without the one that stands for everything outside the map.
    """

    def __init__(self, tiles: int) -> None:
        self.tiles = tiles
        self.record = np.zeros(RECORD, np.int64)
        self.field = self._recorded(FIELD, _aligned(tiles * CELLS, np.uint32))
        self.tables = self._recorded(TABLES, _aligned((tiles + 1) * TABLE, np.uint32))
        self.marks = self._recorded(MARKS, np.empty(tiles + 1, np.uint8))
        self.costs = self._recorded(COSTS, _aligned(tiles * CELLS, np.uint8))
        self._words = _aligned(-(-tiles // GROUP) * GROUP, np.uint32)
        self._share_among(1, tiles)
        self._allocate_scratch(1)
        self._lent = False
        self._map: tuple[weakref.ref[NDArray[np.uint8]], bool] | None = None

    @property
    def knows_map(self) -> bool:
        """Whether its tables belong to a read-only map."""
        return self._map is not None

    def begin(
        self, source: NDArray[np.uint8], tiles: tuple[int, int], threads: int, costmap: Costmap, allow_unknown: bool
    ) -> bool:
        """Prepare the arrays for a new field.

        Parameters
        ----------
        source : (height · width,) uint8 array
            Costs of the map; the caller must hold it as long as this memory is in use.
        tiles : int, int
            Rows and columns of tiles; their product must not exceed the capacity.
        threads : int
            Maximum number of threads.
        costmap : Costmap
            The map.
        allow_unknown : bool
            Whether unknown cells are free.

        Returns
        -------
        bool
            Whether the tables that are marked as filled are valid for this map: it is the same read-only array as for
            the last field.
        """
        self._wait_for_helpers()
        data, count = costmap.data, tiles[0] * tiles[1]
        if len(self._scratch) < threads * SCRATCH:
            self._allocate_scratch(threads)
        if self._sharing != (threads, count):
            self._share_among(threads, count)
        self.record[:TARGET] = *costmap.info.shape, ALL if allow_unknown else 0, tiles[1], count
        store_array(self.record, SOURCE, source)
        self.record[SCRATCH_MEMORY + 1] = threads * SCRATCH
        knows = self._map is not None and self._map[0]() is data and self._map[1] == allow_unknown
        self._map = None if data.flags.writeable else (weakref.ref(data), allow_unknown)
        return knows

    def _allocate_scratch(self, threads: int) -> None:
        self._scratch = self._recorded(SCRATCH_MEMORY, _aligned(threads * SCRATCH, np.uint32))
        self.state = self._recorded(STATE, _aligned(state_size(threads), np.int64))
        self.state[:] = 0

    def _share_among(self, threads: int, tiles: int) -> None:
        self._sharing = threads, tiles
        groups = -(-tiles // GROUP)
        size = threads * part_size(groups, threads)
        self.words = self._recorded(WORDS, self._words[: groups * GROUP])
        self.hints = self._recorded(HINTS, _aligned(size, np.uint32))
        self.places = self._recorded(PLACES, np.zeros(groups + size, np.uint32))
        deal_groups(self.places, groups, threads)

    def _recorded(self, place: int, array: NDArray[T]) -> NDArray[T]:
        """Write address and length of an array into the record, and return the array."""
        store_array(self.record, place, array)
        return array

    def open_for_help(self, target: int) -> None:
        """Allow helpers to join, after the last call's helpers have left.

        Parameters
        ----------
        target : int
            Element of the field whose value is wanted, or −1 for all.
        """
        self._wait_for_helpers()
        self.record[TARGET] = target
        self.state[STOP] = 0

    def close_for_help(self, boxes: NDArray[np.int64]) -> None:
        """Ask all helpers to leave, without waiting: the scheduler may have preempted one."""
        if len(boxes):
            release_helpers(boxes, self.record)
            self._lent = True

    @property
    def is_used(self) -> bool:
        """Whether a helper is still using the arrays."""
        return self._lent and any(self.state[THREADS + CALLED :: APART].tolist())

    def _wait_for_helpers(self) -> None:
        while self.is_used:
            wait_briefly()
        self._lent = False


_spare: list[TileMemory] = []
"""Memory that no field uses: at most one object."""

_left_to_helpers: list[tuple[TileMemory, NDArray[np.uint8]]] = []
"""Memory of deleted fields that preempted helpers still use, with the costs of the map."""


def acquire(tiles: int) -> TileMemory:
    """Return memory for ``tiles`` tiles: the one released last if its size fits, else new memory."""
    while _spare:
        memory = _spare.pop()
        if tiles <= memory.tiles <= MAX_OVERSIZE * tiles:
            return memory
    return TileMemory(tiles)


def release(memory: TileMemory, source: NDArray[np.uint8]) -> None:
    """Keep memory for the next field if its map is read-only; else free it.

    Clones plan on changing maps, at most once a second, and should use little memory in between.

    Parameters
    ----------
    memory : TileMemory
    source : array
        Costs of the map, which helpers that have not left may still read.
    """
    _left_to_helpers[:] = [pair for pair in _left_to_helpers if pair[0].is_used]
    if memory.is_used:
        _left_to_helpers.append((memory, source))
    _spare[:] = [memory] if memory.knows_map else []


class Loan:
    """Owner of the memory of one field, which releases it when it is deleted; see `release`."""

    __slots__ = "_memory", "_source"

    def __init__(self, memory: TileMemory, source: NDArray[np.uint8]) -> None:
        self._memory, self._source = memory, source

    def __del__(self) -> None:
        release(self._memory, self._source)


def _aligned(count: int, dtype: type[T]) -> NDArray[T]:
    size = count * np.dtype(dtype).itemsize
    octets = np.empty(size + ALIGNED, np.uint8)
    begin = -octets.ctypes.data % ALIGNED
    return octets[begin : begin + size].view(dtype)


def _forget_helpers() -> None:
    """Drop memory that threads of the parent process may be using."""
    _spare.clear()
    _left_to_helpers.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_helpers)
