"""Kernel parts: lock-free priority queue of tiles for any number of threads.

The state of a tile is one number, its *word*, which changes atomically:

- the highest bit: a thread is working on the tile;
- 22 bits, its *key*: the least value that a neighbour would improve in it, in units of 1024; the maximum if the tile is
  not queued;
- 9 bits: which neighbours woke it.

The queued tile with the least word is next. To find it without reading all words, there is a *hint* for each group of
tiles: a lower bound of the words of its queued tiles. A hint may be too high for a moment, until the thread that raised
it has checked the words again and corrected it.

Each thread *owns* groups in bands across the map and prefers their tiles: most neighbours of a tile are then processed
by the same thread, and are in the cache of its core. A thread takes a tile of another thread if its key is lower by
more than `AWAY`. So no thread runs far ahead, and none is idle as long as tiles are queued.

The hints of a thread's groups are contiguous, its *part*, and no cache line holds hints of two threads. A thread reads
the other parts only occasionally: each read takes the cache line from the core that writes to it.

No update is lost: a thread that lowers a word reads the hint afterwards, and a thread that raises a hint reads the
words afterwards. All these steps are sequentially consistent, so at least one of the two sees the other's change."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, joined
from ppaas.planners.field.kernels.tile_layout import ALL, BASE, SIDE
from ppaas.planners.kernels import atomics, simd

Int = int | np.signedinteger[Any]
Numbers = NDArray[np.uint32]

GROUP = 4 * SIDE
"""Tiles in a group."""
REASONS = (1 << 9) - 1
"""Mask of the bits of neighbours that woke a tile."""
UNIT_SHIFT = 10
KEY_SHIFT = 9
IDLE = (1 << 31) - 1 - REASONS
"""Word of a tile that is not queued, and hint of a group without queued tiles."""
BUSY = 1 << 31
"""Bit of a tile that a thread is working on."""
NONE = -1
"""No tile."""
LOOK_AFTER = 8
"""Number of own tiles that a thread takes between two reads of the other parts."""
AWAY = (SIDE * BASE >> UNIT_SHIFT) << KEY_SHIFT
"""Penalty on words of other threads' groups: the least weight of a straight path through a tile."""


@bare
def wake(words: Numbers, hints: Numbers, places: Numbers, tile: Int, value: Int, reason: Int) -> bool:
    """Queue a tile with a value, or lower its key to it; return whether it was idle before."""
    key = (value >> UNIT_SHIFT) << KEY_SHIFT
    while True:
        word = atomics.read(words, tile)
        old_key = word & ~REASONS & ~BUSY
        woken = min(old_key, key) | (word & (REASONS | BUSY)) | 1 << reason
        # Also if the word is unchanged: the thread that takes the tile must see what was written before this step.
        if atomics.replace(words, tile, word, woken):
            break
    if not word & BUSY:
        _lower_hint(hints, places, tile, woken)
    return bool(word == IDLE)


@bare
def let_go(words: Numbers, hints: Numbers, places: Numbers, tile: Int) -> bool:
    """End the work on a tile; return whether it is queued again, because it was woken meanwhile."""
    while True:
        word = atomics.read(words, tile)
        if atomics.replace(words, tile, word, word & ~BUSY):
            break
    again = bool(word & ~BUSY != IDLE)
    if again:
        _lower_hint(hints, places, tile, word & ~BUSY)
    return again


@bare
def deal_groups(places: Numbers, groups: Int, threads: Int) -> None:
    """Assign the groups to the threads in bands, at least two bands per thread if there are enough groups.

    Parameters
    ----------
    places : (groups + threads · part_size(groups, threads),) uint32 array
        Out: index of the hint of each group; behind them the group of each hint.
    groups, threads : int
        Numbers of groups and of threads.
    """
    each, part = band(groups, threads), part_size(groups, threads)
    for group in range(groups):
        turn = group // each
        place = turn % threads * part + turn // threads * each + group % each
        places[group] = place
        places[groups + place] = group


@joined
def band(groups: Int, threads: Int) -> Int:
    """Return the number of successive groups in a band."""
    return max(1, min(groups // (2 * threads), SIDE // threads))


@joined
def part_size(groups: Int, threads: Int) -> Int:
    """Return the number of hints per thread, including unused ones: a multiple of 32."""
    each: Int = band(groups, threads)
    turns = -(-groups // (each * threads))
    return -(-turns * each // SIDE) * SIDE


@bare
def take(
    words: Numbers, hints: Numbers, places: Numbers, bound: Int, begin: Int, count: Int, looks: bool
) -> tuple[Int, Int]:
    """Take the next tile from the queue.

    Parameters
    ----------
    words : (n,) uint32 array
        Word of each tile, padded to whole groups. In and out.
    hints : (m,) uint32 array
        Hints of the groups. In and out.
    places : uint32 array
        As in `deal_groups`.
    bound : int
        Tiles with this word or a greater one are not taken.
    begin, count : int
        The thread's own part of the hints.
    looks : bool
        Whether to read the other parts even if a tile of its own is queued.

    Returns
    -------
    tile : int
        The tile, or `NONE` if there is none below the bound.
    word : int
        Its word.
    """
    while True:
        hint, place = _least(hints, begin, count)
        if count < len(hints) and (looks or hint >= bound):
            other, elsewhere = _least(hints, np.int64(0), len(hints))
            if hint >= bound or other + AWAY < hint:
                hint, place = other, elsewhere
        if hint >= bound:
            return np.int64(NONE), hint
        group = np.int64(places[len(words) // GROUP + place])
        word, tile = _least(words, group * GROUP, np.int64(GROUP))
        taken = (word & ~REASONS) <= hint and atomics.replace(words, tile, word, BUSY | IDLE)
        if taken or (word & ~REASONS) > hint:
            _raise_hint(words, hints, group, place, hint)
        if taken:
            return tile, word


@bare
def until_look(before: Int, is_own: bool) -> Int:
    """Return how many more tiles a thread takes before it reads the other parts; 0 after a tile of another thread.

    Parameters
    ----------
    before : int
        The last result.
    is_own : bool
        Whether the tile taken last was the thread's own.
    """
    return 0 if not is_own else before - 1 if before > 0 else LOOK_AFTER - 1


@bare
def waits(hints: Numbers, bound: Int) -> bool:
    """Return whether a tile below a bound is queued."""
    return bool(_least(hints, np.int64(0), len(hints))[0] < bound)


@joined
def _least(numbers: Numbers, begin: Int, count: Int) -> tuple[Int, Int]:
    """Return the least of ``count`` numbers, a multiple of 32, and its index."""
    best = simd.load(numbers, begin)
    for at in range(begin + SIDE, begin + count, SIDE):
        best = simd.least(best, simd.load(numbers, at))
    least = simd.least_of(best)
    found: Int = begin
    for at in range(begin, begin + count, SIDE):
        other = simd.unlike(simd.load(numbers, at), simd.splat(least))
        if other != ALL:
            found = at + simd.first_lane(~other)
            break
    # Other threads may have changed the number since.
    return least, found


@bare
def _lower_hint(hints: Numbers, places: Numbers, tile: Int, word: Int) -> None:
    place, key = np.int64(places[tile // GROUP]), word & ~REASONS
    if atomics.read(hints, place) > key:
        atomics.lower(hints, place, key)


@bare
def _raise_hint(words: Numbers, hints: Numbers, group: Int, place: Int, hint: Int) -> None:
    """Raise a hint to the least key of its group, unless another thread has changed it."""
    key = _key_of(words, group)
    if key > hint and atomics.replace(hints, place, hint, key):
        atomics.fence()
        again = _key_of(words, group)
        if again < key:
            atomics.lower(hints, place, again)


@bare
def _key_of(words: Numbers, group: Int) -> Int:
    least = _least(words, group * GROUP, np.int64(GROUP))[0]
    return IDLE if least >= BUSY else least & ~REASONS
