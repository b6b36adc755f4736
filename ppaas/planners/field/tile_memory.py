"""The arrays of a field of tiles, which the next field takes over: fresh memory costs as much time as the field."""

import os
import weakref
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.field.kernels.tile_help import rest, send_away
from ppaas.planners.field.kernels.tile_layout import ALL, CELLS, TABLE
from ppaas.planners.field.kernels.tile_queue import GROUP, lay_places, part_size
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
    note,
)
from ppaas.planners.field.kernels.tile_rows import SCRATCH
from ppaas.planners.field.kernels.tile_state import ALIGNED, APART, CALLED, STOP, THREADS, state_size

T = TypeVar("T", bound=np.generic)

MOST_TOO_LARGE = 4
"""Arrays that are larger than needed by more than this factor are not taken over."""


class TileMemory:
    """The arrays of one field at a time; see `ppaas.planners.field.kernels.tile_record` for what they hold.

    Parameters
    ----------
    tiles : int
        For how many tiles there is room, beside the one that stands for all outside.
    """

    def __init__(self, tiles: int) -> None:
        self.tiles = tiles
        self.record = np.zeros(RECORD, np.int64)
        self.field = self._kept(FIELD, _aligned(tiles * CELLS, np.uint32))
        self.tables = self._kept(TABLES, _aligned((tiles + 1) * TABLE, np.uint32))
        self.marks = self._kept(MARKS, np.empty(tiles + 1, np.uint8))
        self.costs = self._kept(COSTS, _aligned(tiles * CELLS, np.uint8))
        self._words = _aligned(-(-tiles // GROUP) * GROUP, np.uint32)
        self._share_among(1, tiles)
        self._make_room(1)
        self._lent = False
        self._map: tuple[weakref.ref[NDArray[np.uint8]], bool] | None = None

    @property
    def knows_map(self) -> bool:
        """Whether its tables are of a map that nobody can write to."""
        return self._map is not None

    def begin(
        self, source: NDArray[np.uint8], tiles: tuple[int, int], threads: int, costmap: Costmap, allow_unknown: bool
    ) -> bool:
        """Make it ready for a new field; return whether tables that are filled are those of its map.

        They are if the map is the one before and nobody can have written to it.

        Parameters
        ----------
        source : (height · width,) uint8 array
            Costs of the map, to be held until nobody uses this memory.
        tiles : int, int
            From the top of the map to its bottom, and across: no more in all than there is room for.
        threads : int
            Most that will be used.
        costmap : Costmap
            The map.
        allow_unknown : bool
            Whether unknown cells are free.
        """
        self._wait_for_helpers()
        data, count = costmap.data, tiles[0] * tiles[1]
        if len(self._scratch) < threads * SCRATCH:
            self._make_room(threads)
        if self._sharing != (threads, count):
            self._share_among(threads, count)
        self.record[:TARGET] = *costmap.info.shape, ALL if allow_unknown else 0, tiles[1], count
        note(self.record, SOURCE, source)
        self.record[SCRATCH_MEMORY + 1] = threads * SCRATCH
        knows = self._map is not None and self._map[0]() is data and self._map[1] == allow_unknown
        self._map = None if data.flags.writeable else (weakref.ref(data), allow_unknown)
        return knows

    def _make_room(self, threads: int) -> None:
        self._scratch = self._kept(SCRATCH_MEMORY, _aligned(threads * SCRATCH, np.uint32))
        self.state = self._kept(STATE, _aligned(state_size(threads), np.int64))
        self.state[:] = 0

    def _share_among(self, threads: int, tiles: int) -> None:
        self._sharing = threads, tiles
        groups = -(-tiles // GROUP)
        size = threads * part_size(groups, threads)
        self.words = self._kept(WORDS, self._words[: groups * GROUP])
        self.hints = self._kept(HINTS, _aligned(size, np.uint32))
        self.places = self._kept(PLACES, np.zeros(groups + size, np.uint32))
        lay_places(self.places, groups, threads)

    def _kept(self, place: int, array: NDArray[T]) -> NDArray[T]:
        """Note in the record where an array lies that this memory holds."""
        note(self.record, place, array)
        return array

    def open_for_help(self, target: int) -> None:
        """Let helpers come, after those have left that were called before.

        Parameters
        ----------
        target : int
            Element of the field whose value is wanted, or −1.
        """
        self._wait_for_helpers()
        self.record[TARGET] = target
        self.state[STOP] = 0

    def close_for_help(self, boxes: NDArray[np.int64]) -> None:
        """Tell all helpers to leave, but do not wait for them: one may have been put aside for a while."""
        if len(boxes):
            send_away(boxes, self.record)
            self._lent = True

    @property
    def is_used(self) -> bool:
        """Whether a helper has not left yet."""
        return self._lent and any(self.state[THREADS + CALLED :: APART].tolist())

    def _wait_for_helpers(self) -> None:
        while self.is_used:
            rest()
        self._lent = False


_spare: list[TileMemory] = []
"""At most one that no field uses."""

_left_to_helpers: list[tuple[TileMemory, NDArray[np.uint8]]] = []
"""What helpers still use of fields that are gone, as they were put aside."""


def take(tiles: int) -> TileMemory:
    """Return memory for that many tiles: what was given back last, if it is large enough and not far too large."""
    while _spare:
        memory = _spare.pop()
        if tiles <= memory.tiles <= MOST_TOO_LARGE * tiles:
            return memory
    return TileMemory(tiles)


def give_back(memory: TileMemory, source: NDArray[np.uint8]) -> None:
    """Let the next field have memory that is not used any longer, if it knows a map that stays as it is.

    Who plans on maps that change is a robot, once a second at most: it is to weigh little in between.

    Parameters
    ----------
    memory : TileMemory
    source : array
        Costs of the map, which helpers read that have not left yet.
    """
    _left_to_helpers[:] = [pair for pair in _left_to_helpers if pair[0].is_used]
    if memory.is_used:
        _left_to_helpers.append((memory, source))
    _spare[:] = [memory] if memory.knows_map else []


class Loan:
    """Gives memory back as it goes, as its field does that alone holds it; see `give_back`."""

    __slots__ = "_memory", "_source"

    def __init__(self, memory: TileMemory, source: NDArray[np.uint8]) -> None:
        self._memory, self._source = memory, source

    def __del__(self) -> None:
        give_back(self._memory, self._source)


def _aligned(count: int, dtype: type[T]) -> NDArray[T]:
    size = count * np.dtype(dtype).itemsize
    octets = np.empty(size + ALIGNED, np.uint8)
    begin = -octets.ctypes.data % ALIGNED
    return octets[begin : begin + size].view(dtype)


def _forget_helpers() -> None:
    """Forget what threads of the process work at from which this one was forked."""
    _spare.clear()
    _left_to_helpers.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_helpers)
