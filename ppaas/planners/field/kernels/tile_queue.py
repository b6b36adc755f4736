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

The hints of a thread's own groups lie side by side, in its *part* of them, and no line of memory holds those of two
threads. It looks at the other parts only now and then: each look fetches what another core has just written, which that
core has to fetch back.

Nothing is lost: who lowers a word looks at its hint after that, and who raises a hint looks at the words after that. As
the order of all these steps is the same for all threads, one of the two sees what the other did.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.field.kernels.tile_layout import ALL, BASE, SIDE
from ppaas.planners.kernels import atomics, simd
from ppaas.planners.kernels.jit_decorators import bare, joined

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
LOOK_AFTER = 8
"""So many tiles of its own a thread takes in turn between two looks at others'."""
AWAY = (SIDE * BASE >> UNIT_SHIFT) << KEY_SHIFT
"""How much greater words of others' groups count: what a straight way through a tile weighs at least."""


@bare
def wake(words: Numbers, hints: Numbers, places: Numbers, tile: Int, value: Int, reason: Int) -> bool:
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
        _lower_hint(hints, places, tile, woken)
    return bool(word == IDLE)


@bare
def let_go(words: Numbers, hints: Numbers, places: Numbers, tile: Int) -> bool:
    """End the work on a tile; return whether it waits again, because somebody woke it meanwhile."""
    while True:
        word = atomics.read(words, tile)
        if atomics.replace(words, tile, word, word & ~BUSY):
            break
    again = bool(word & ~BUSY != IDLE)
    if again:
        _lower_hint(hints, places, tile, word & ~BUSY)
    return again


@bare
def lay_places(places: Numbers, groups: Int, threads: Int) -> None:
    """Deal the groups to the threads in bands, two for each on small maps.

    Parameters
    ----------
    places : (groups + threads · part_size(groups, threads),) uint32 array
        Out: where the hint of each group is; behind them, for each hint, of which group it is.
    groups, threads : int
    """
    each, part = band(groups, threads), part_size(groups, threads)
    for group in range(groups):
        turn = group // each
        place = turn % threads * part + turn // threads * each + group % each
        places[group] = place
        places[groups + place] = group


@joined
def band(groups: Int, threads: Int) -> Int:
    """Return how many groups side by side are one thread's own."""
    return max(1, min(groups // (2 * threads), SIDE // threads))


@joined
def part_size(groups: Int, threads: Int) -> Int:
    """Return how many hints there are for each thread, those without a group included: a multiple of 32."""
    each: Int = band(groups, threads)
    turns = -(-groups // (each * threads))
    return -(-turns * each // SIDE) * SIDE


@bare
def take(
    words: Numbers, hints: Numbers, places: Numbers, bound: Int, begin: Int, count: Int, looks: bool
) -> tuple[Int, Int]:
    """Take the tile to be worked on next.

    Parameters
    ----------
    words, hints, places
    bound : int
        Tiles with this word or a greater one are left alone.
    begin, count : int
        Where the thread's own part of the hints is.
    looks : bool
        Whether it looks at others' tiles even if one of its own waits.

    Returns
    -------
    tile : int
        `NONE` if there is none below the bound.
    word : int
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
    """Return how many tiles a thread takes yet before it looks at others': none as long as theirs are nearer.

    Parameters
    ----------
    before : int
        The same, before it took the last tile.
    is_own : bool
        Whether that was one of its own.
    """
    return 0 if not is_own else before - 1 if before > 0 else LOOK_AFTER - 1


@bare
def waits(hints: Numbers, bound: Int) -> bool:
    """Return whether a tile waits below a bound."""
    return bool(_least(hints, np.int64(0), len(hints))[0] < bound)


@joined
def _least(numbers: Numbers, begin: Int, count: Int) -> tuple[Int, Int]:
    """Return the least of so many numbers, a multiple of 32, and where it was."""
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
    # As it was when it was the least: by now it may be another.
    return least, found


@bare
def _lower_hint(hints: Numbers, places: Numbers, tile: Int, word: Int) -> None:
    place, key = np.int64(places[tile // GROUP]), word & ~REASONS
    if atomics.read(hints, place) > key:
        atomics.lower(hints, place, key)


@bare
def _raise_hint(words: Numbers, hints: Numbers, group: Int, place: Int, hint: Int) -> None:
    """Set a hint to what it should be, if it is as it was and should be greater."""
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
