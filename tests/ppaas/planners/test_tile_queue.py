from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.planners.kernels.tile_layout import ALL, SIDE, UNREACHED
from ppaas.planners.kernels.tile_queue import (
    AWAY,
    GROUP,
    IDLE,
    KEY_SHIFT,
    NONE,
    REASONS,
    UNIT_SHIFT,
    let_go,
    own_groups,
    take,
    waits,
    wake,
)
from tests.reference.waiting import Waiting

GROUPS = 40
TILES = GROUPS * GROUP

WAKES = st.tuples(st.integers(0, TILES - 1), st.integers(0, UNREACHED - 1), st.integers(0, 8))
STEPS = st.one_of(WAKES, st.just("take"), st.just("let go"))


def empty():
    return np.full(TILES, IDLE, np.uint32), np.full(-(-GROUPS // SIDE) * SIDE, IDLE, np.uint32)


def reasons_of(word):
    return {reason for reason in range(9) if word >> reason & 1}


@given(st.lists(STEPS, max_size=60))
@settings(deadline=None, max_examples=150)
def test_tiles_are_taken_by_their_keys_with_all_that_woke_them(steps):
    words, hints = empty()
    twin, at_work = Waiting(), []
    for step in steps:
        if step == "let go" and at_work:
            tile = at_work.pop(0)
            assert let_go(words, hints, tile) == twin.let_go(tile)
        elif step == "take":
            least = twin.least()
            assert waits(hints, IDLE) == (least is not None)
            tile, word = take(words, hints, IDLE, ALL)
            assert (tile == NONE) == (least is None)
            if tile != NONE:
                assert ((word & ~REASONS) >> KEY_SHIFT, reasons_of(word)) == twin.take(tile)
                assert word >> KEY_SHIFT == least
                at_work.append(tile)
        elif isinstance(step, tuple):
            tile, value, reason = step
            assert wake(words, hints, tile, value, reason) == twin.wake(tile, value >> UNIT_SHIFT, reason)


def test_nothing_is_taken_from_the_bound_on():
    words, hints = empty()
    wake(words, hints, 700, 5 << UNIT_SHIFT, 3)
    assert take(words, hints, 5 << KEY_SHIFT, ALL) == (NONE, 5 << KEY_SHIFT)
    assert take(words, hints, 6 << KEY_SHIFT, ALL)[0] == 700


@given(
    st.dictionaries(st.integers(0, TILES - 1), st.integers(0, 4 * AWAY >> KEY_SHIFT), min_size=1, max_size=20),
    st.integers(0, 5 * AWAY), st.integers(1, 3), st.integers(0, 2),
)  # fmt: skip
@settings(deadline=None, max_examples=100)
def test_a_thread_takes_from_its_own_groups_what_is_not_much_farther_and_else_what_there_is(
    keys, bound, threads, number
):
    words, hints = empty()
    own = own_groups(number % threads, threads, GROUPS)
    for tile, key in keys.items():
        wake(words, hints, tile, key << UNIT_SHIFT, 0)

    def counted(tile):
        return (keys[tile] << KEY_SHIFT) + (0 if own >> tile // GROUP % SIDE & 1 else AWAY)

    first = [tile for tile in keys if counted(tile) == min(map(counted, keys))]
    waiting = [tile for tile in keys if keys[tile] << KEY_SHIFT < bound]
    tile, _word = take(words, hints, bound, own)
    assert tile in (waiting or [NONE])
    assert tile in first or not set(first) <= set(waiting)


@pytest.mark.parametrize("groups", [1, 8, 32, 200])
@pytest.mark.parametrize("threads", [1, 2, 3, 7, 16, 40])
def test_each_group_is_one_thread_s_own_and_of_many_each_thread_has_some(threads, groups):
    owned = [own_groups(thread, threads, groups) for thread in range(threads)]
    assert sum(owned) == ALL
    assert sum(own.bit_count() for own in owned) == SIDE
    assert threads > min(groups, SIDE) or all(own & (1 << groups) - 1 for own in owned)


def test_threads_that_wake_and_take_at_a_time_lose_nothing_and_are_never_at_the_same_tile():
    words, hints = empty()
    threads, each = 6, 3_000
    busy = np.zeros(TILES, np.int64)

    def push_on(number):
        """Wake a tile and take one, again and again; return the least number of tiles that was ever at work."""
        rng, taken = np.random.default_rng(number), 0
        for _ in range(each):
            wake(words, hints, int(rng.integers(4 * GROUP)), int(rng.integers(UNREACHED)), number)
            tile, _word = take(words, hints, IDLE, ALL)
            if tile != NONE:
                busy[tile] += 1
                assert busy[tile] == 1
                busy[tile] -= 1
                let_go(words, hints, tile)
                taken += 1
        return taken

    with ThreadPoolExecutor(threads) as pool:
        assert all(taken > 0 for taken in pool.map(push_on, range(threads)))
    while (tile := take(words, hints, IDLE, ALL)[0]) != NONE:
        let_go(words, hints, tile)
    assert (words == IDLE).all()
    assert (hints == IDLE).all()
