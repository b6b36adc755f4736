"""The arrays of a field of tiles, which the next field takes over: fresh memory costs as much time as the field."""

import weakref
from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.kernels.tile_growth import APART, CALLED, STOP, THREADS, state_size
from ppaas.planners.kernels.tile_layout import CELLS, EDGES, FREE, KIND, LAID, TABLE, UNREACHED
from ppaas.planners.kernels.tile_queue import GROUP, IDLE, lay_places, part_size
from ppaas.planners.kernels.tile_rows import SCRATCH
from ppaas.planners.workers import Helpers

T = TypeVar("T", bound=np.generic)

LINE = 64
"""Bytes of a cache line."""
MOST_TOO_LARGE = 4
"""Arrays that are larger than needed by more than this factor are not taken over."""


class TileMemory:
    """The arrays of one field at a time; see `ppaas.planners.kernels.tile_growth` for what they hold.

    Parameters
    ----------
    tiles : int
        For how many tiles there is room, beside the one that stands for all outside.
    """

    def __init__(self, tiles: int) -> None:
        self.tiles = tiles
        self.field = _aligned(tiles * CELLS, np.uint32)
        self.tables = _aligned((tiles + 1) * TABLE, np.uint32)
        self.costs = _aligned(tiles * CELLS, np.uint8)
        self.marks = np.empty(tiles + 1, np.uint8)
        self._words = _aligned(-(-tiles // GROUP) * GROUP, np.uint32)
        self._share_among(1, tiles)
        self.scratch = _scratch(1)
        self.state = _aligned(state_size(1), np.int64)
        self.helpers = Helpers()
        self._map: tuple[weakref.ref[NDArray[np.uint8]], bool] | None = None

    @property
    def knows_map(self) -> bool:
        """Whether its tables are of a map that nobody can write to."""
        return self._map is not None

    def begin(self, tiles: int, threads: int, data: NDArray[np.uint8], allow_unknown: bool) -> None:
        """Make it ready for a new field.

        Tables that are filled are kept if the map is the one before and nobody can have written to it.

        Parameters
        ----------
        tiles : int
            No more than there is room for.
        threads : int
            Most that will be used.
        data : (height, width) uint8 array
            Costs of the map.
        allow_unknown : bool
            Whether unknown cells are free.
        """
        self._wait_for_helpers()
        if len(self.scratch) < threads:
            self.scratch = _scratch(threads)
            self.state = _aligned(state_size(threads), np.int64)
        if self._sharing != (threads, tiles):
            self._share_among(threads, tiles)
        if self._map is not None and self._map[0]() is data and self._map[1] == allow_unknown:
            self.marks[: tiles + 1] &= LAID
        else:
            self.marks[: tiles + 1] = 0
        self._map = None if data.flags.writeable else (weakref.ref(data), allow_unknown)
        self.words[:] = IDLE
        self.hints[:] = IDLE
        self.state[:] = 0
        outside = self.tables[tiles * TABLE : (tiles + 1) * TABLE]
        outside[EDGES:FREE] = UNREACHED
        outside[FREE : KIND + 1] = 0
        self.marks[tiles] = LAID

    def _share_among(self, threads: int, tiles: int) -> None:
        self._sharing = threads, tiles
        groups = -(-tiles // GROUP)
        size = threads * part_size(groups, threads)
        self.words = self._words[: groups * GROUP]
        self.hints = _aligned(size, np.uint32)
        self.places = np.zeros(groups + size, np.uint32)
        lay_places(self.places, groups, threads)

    def open_for_help(self) -> None:
        """Let helpers come, after those have left that were called before."""
        self._wait_for_helpers()
        self.state[STOP] = 0
        self._called[:] = 0

    def call_help(self, work: Callable[[int], object]) -> None:
        """Call one more helper, who is given its number: the first that is free."""
        number = int(np.argmin(self._called[1:])) + 1
        self._called[number] = 1
        self.helpers.call(lambda: work(number))

    def close_for_help(self) -> None:
        """Tell all helpers to leave, but do not wait for them: one may have been put aside for a while."""
        self.state[STOP] = 1
        self.helpers.send_away()

    def _wait_for_helpers(self) -> None:
        """Wait until nobody uses this memory; who has left the kernel need not have told so."""
        if self._called[1:].any():
            self.helpers.wait()
        else:
            self.helpers.forget()

    @property
    def _called(self) -> NDArray[np.int64]:
        return self.state[THREADS + CALLED :: APART]


_spare: list[TileMemory] = []
"""At most one that no field uses."""


def take(tiles: int) -> TileMemory:
    """Return memory for that many tiles: what was given back last, if it is large enough and not far too large."""
    while _spare:
        memory = _spare.pop()
        if tiles <= memory.tiles <= MOST_TOO_LARGE * tiles:
            return memory
    return TileMemory(tiles)


def give_back(memory: TileMemory) -> None:
    """Let the next field have memory that is not used any longer, if it knows a map that stays as it is.

    Who plans on maps that change is a robot, once a second at most: it is to weigh little in between.
    """
    _spare[:] = [memory] if memory.knows_map else []


def _aligned(count: int, dtype: type[T]) -> NDArray[T]:
    size = count * np.dtype(dtype).itemsize
    octets = np.empty(size + LINE, np.uint8)
    begin = -octets.ctypes.data % LINE
    return octets[begin : begin + size].view(dtype)


def _scratch(threads: int) -> NDArray[np.uint32]:
    each = -(-SCRATCH // LINE) * LINE
    return _aligned(threads * each, np.uint32).reshape(threads, each)
