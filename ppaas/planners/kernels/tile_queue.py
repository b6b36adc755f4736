"""Kernel parts: which tiles wait, which comes first, and who works on it: for any number of threads, without a lock.

All that is known of a tile is in one number, its *word*, so that it changes in one step:

- the topmost bit: somebody works on it;
- 22 bits, its *key*: about the least value that a neighbour would better in it, in units of 1024; the greatest there
  is if it does not wait;
- 9 bits: which neighbours woke it.

Words are compared as they are, so the least is that of the tile to be taken next. So that not all have to be looked at,
there is a *hint* for each group of tiles: no greater than the least word of those that wait for somebody, but for
moments in which a thread, which looks again before it goes on, has not yet put right what it raised too high.

Threads prefer tiles of *their own* groups, which lie in bands across the map: most neighbours of a tile are then worked
on by the same thread, and what it reads of them is in its own core's cache. A tile of others is taken if it is nearer
by more than `AWAY`: so no thread hurries far ahead, and none is out of work as long as there is any.

Nothing is lost: who lowers a word looks at its hint after that, and who raises a hint looks at the words after that. As
the order of all these steps is the same for all threads, one of the two sees what the other did.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.kernels import atomics, simd
from ppaas.planners.kernels.bare import bare, joined
from ppaas.planners.kernels.tile_layout import ALL, BASE, SIDE

Int = int | np.signedinteger[Any]
Numbers = NDArray[np.uint32]

GROUP = 4 * SIDE
"""Tiles of a group."""
REASONS = (1 << 9) - 1
UNIT_SHIFT = 10
KEY_SHIFT = 9
IDLE = (1 << 31) - 1 - REASONS
"""The word of a tile that does not wait, and the hint of a group in which none does."""
BUSY = 1 << 31
"""The bit of a tile that somebody works on."""
NONE = -1
"""No tile."""
AWAY = (SIDE * BASE >> UNIT_SHIFT) << KEY_SHIFT
"""How much greater words of others' groups count: what a straight way through a tile weighs at least."""


@bare
def wake(words: Numbers, hints: Numbers, tile: Int, value: Int, reason: Int) -> bool:
    """Let a tile wait with a value, unless it waits with a lesser one; return whether it was idle."""
    key = (value >> UNIT_SHIFT) << KEY_SHIFT
    while True:
        word = atomics.read(words, tile)
        rest = word & ~REASONS & ~BUSY
        woken = min(rest, key) | (word & (REASONS | BUSY)) | 1 << reason
        # Even if it stays as it was: who takes the tile is to see what was written before this.
        if atomics.replace(words, tile, word, woken):
            break
    if not word & BUSY:
        _lower_hint(hints, tile, woken)
    return bool(word == IDLE)


@bare
def let_go(words: Numbers, hints: Numbers, tile: Int) -> bool:
    """End the work on a tile; return whether it waits again, because somebody woke it meanwhile."""
    while True:
        word = atomics.read(words, tile)
        if atomics.replace(words, tile, word, word & ~BUSY):
            break
    again = bool(word & ~BUSY != IDLE)
    if again:
        _lower_hint(hints, tile, word & ~BUSY)
    return again


@bare
def own_groups(thread: Int, threads: Int, groups: Int) -> Int:
    """Return which groups are a thread's own, as lanes of each 32 hints: bands, two for each thread on small maps."""
    each, own = max(1, min(groups // (2 * threads), SIDE // threads)), 0
    for lane in range(SIDE):
        if lane // each % threads == thread:
            own |= 1 << lane
    return own


@bare
def take(words: Numbers, hints: Numbers, bound: Int, own: Int) -> tuple[Int, Int]:
    """Take the tile to be worked on next; return it, or `NONE` if there is none below a bound, and its word."""
    while True:
        hint, group = _least(hints, np.int64(0), len(hints), own)
        if hint >= bound:
            hint, group = _least(hints, np.int64(0), len(hints), np.int64(ALL))
        if hint >= bound:
            return np.int64(NONE), hint
        word, tile = _least(words, group * GROUP, np.int64(GROUP), np.int64(ALL))
        if (word & ~REASONS) <= hint and atomics.replace(words, tile, word, BUSY | IDLE):
            _raise_hint(words, hints, group, hint)
            return tile, word
        if (word & ~REASONS) > hint:
            _raise_hint(words, hints, group, hint)


@bare
def waits(hints: Numbers, bound: Int) -> bool:
    """Return whether a tile waits below a bound."""
    return bool(_least(hints, np.int64(0), len(hints), np.int64(ALL))[0] < bound)


@joined
def _counted(numbers: Numbers, at: Int, own: Int) -> Any:
    row = simd.load(numbers, at)
    return simd.where(own, row, simd.add(row, simd.splat(AWAY)))


@joined
def _least(numbers: Numbers, begin: Int, count: Int, own: Int) -> tuple[Int, Int]:
    """Return the least of so many numbers, a multiple of 32, and where it was; others than ``own`` count for more."""
    best = _counted(numbers, begin, own)
    for at in range(begin + SIDE, begin + count, SIDE):
        best = simd.least(best, _counted(numbers, at, own))
    least = simd.least_of(best)
    found: Int = begin
    for at in range(begin, begin + count, SIDE):
        other = simd.unlike(_counted(numbers, at, own), simd.splat(least))
        if other != ALL:
            found = at + simd.first_lane(~other)
            break
    # As it was when it was the least: by now it may be another.
    return (least if own >> found % SIDE & 1 else least - AWAY), found


@bare
def _lower_hint(hints: Numbers, tile: Int, word: Int) -> None:
    group, key = tile // GROUP, word & ~REASONS
    if atomics.read(hints, group) > key:
        atomics.lower(hints, group, key)


@bare
def _raise_hint(words: Numbers, hints: Numbers, group: Int, hint: Int) -> None:
    """Set a hint to what it should be, if it is as it was and should be greater."""
    key = _key_of(words, group)
    if key > hint and atomics.replace(hints, group, hint, key):
        atomics.fence()
        again = _key_of(words, group)
        if again < key:
            atomics.lower(hints, group, again)


@bare
def _key_of(words: Numbers, group: Int) -> Int:
    least = _least(words, group * GROUP, np.int64(GROUP), np.int64(ALL))[0]
    return IDLE if least >= BUSY else least & ~REASONS
