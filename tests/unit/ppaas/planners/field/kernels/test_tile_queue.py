from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.planners.field.kernels.tile_layout import SIDE, UNREACHED
from ppaas.planners.field.kernels.tile_queue import (
    AWAY,
    GROUP,
    IDLE,
    KEY_SHIFT,
    LOOK_AFTER,
    NONE,
    REASONS,
    UNIT_SHIFT,
    deal_groups,
    let_go,
    part_size,
    take,
    until_look,
    waits,
    wake,
)
from tests.reference.planners.dijkstra import Waiting

GROUPS = 40
TILES = GROUPS * GROUP

WAKES = st.tuples(st.integers(0, TILES - 1), st.integers(0, UNREACHED - 1), st.integers(0, 8))
STEPS = st.one_of(WAKES, st.just("take"), st.just("let go"))


def empty(threads=1):
    hints = np.full(threads * part_size(GROUPS, threads), IDLE, np.uint32)
    return np.full(TILES, IDLE, np.uint32), hints, places_of(GROUPS, threads)


def places_of(groups, threads):
    places = np.zeros(groups + threads * part_size(groups, threads), np.uint32)
    deal_groups(places, groups, threads)
    return places


def take_any(words, hints, places, bound=IDLE):
    return take(words, hints, places, bound, 0, len(hints), False)


def reasons_of(word):
    return {reason for reason in range(9) if word >> reason & 1}


@given(st.lists(STEPS, max_size=60))
def test_tiles_are_taken_in_the_order_of_their_keys_with_all_reasons(steps):
    words, hints, places = empty()
    twin, at_work = Waiting(), []
    for step in steps:
        if step == "let go" and at_work:
            tile = at_work.pop(0)
            assert let_go(words, hints, places, tile) == twin.let_go(tile)
        elif step == "take":
            least = twin.least()
            assert waits(hints, IDLE) == (least is not None)
            tile, word = take_any(words, hints, places)
            assert (tile == NONE) == (least is None)
            if tile != NONE:
                assert ((word & ~REASONS) >> KEY_SHIFT, reasons_of(word)) == twin.take(tile)
                assert word >> KEY_SHIFT == least
                at_work.append(tile)
        elif isinstance(step, tuple):
            tile, value, reason = step
            assert wake(words, hints, places, tile, value, reason) == twin.wake(tile, value >> UNIT_SHIFT, reason)


def test_no_tile_at_or_above_the_bound_is_taken():
    words, hints, places = empty()
    wake(words, hints, places, 700, 5 << UNIT_SHIFT, 3)
    assert take_any(words, hints, places, 5 << KEY_SHIFT) == (NONE, 5 << KEY_SHIFT)
    assert take_any(words, hints, places, 6 << KEY_SHIFT)[0] == 700


@given(
    st.dictionaries(st.integers(0, TILES - 1), st.integers(0, 4 * AWAY >> KEY_SHIFT), min_size=1, max_size=20),
    st.integers(0, 5 * AWAY), st.integers(2, 3), st.integers(0, 2), st.booleans(),
)  # fmt: skip
def test_a_thread_prefers_its_own_groups_unless_another_key_is_much_lower(keys, bound, threads, number, looks):
    words, hints, places = empty(threads)
    part = part_size(GROUPS, threads)
    for tile, key in keys.items():
        wake(words, hints, places, tile, key << UNIT_SHIFT, 0)

    def nearest(tiles):
        return min((keys[tile] << KEY_SHIFT for tile in tiles), default=IDLE)

    own = [tile for tile in keys if places[tile // GROUP] // part == number % threads]
    least, least_own = nearest(keys), nearest(own)
    tile, _word = take(words, hints, places, bound, number % threads * part, part, looks)
    if least >= bound:
        assert tile == NONE
    elif least_own >= bound or (looks and least + AWAY < least_own):
        assert keys[tile] << KEY_SHIFT == least
    else:
        assert tile in own
        assert keys[tile] << KEY_SHIFT == least_own


@pytest.mark.parametrize("groups", [1, 8, 32, 200])
@pytest.mark.parametrize("threads", [1, 2, 3, 7, 16, 40])
def test_each_group_has_one_hint_in_one_part_and_every_thread_owns_groups(threads, groups):
    places, part = places_of(groups, threads), part_size(groups, threads)
    assert part % SIDE == 0
    assert len(set(places[:groups])) == groups
    assert all(places[groups + place] == group for group, place in enumerate(places[:groups]))
    owners = set(places[:groups] // part)
    assert owners <= set(range(threads))
    assert len(owners) == min(threads, groups) or groups > SIDE


@given(st.lists(st.booleans(), max_size=50))
def test_a_thread_reads_other_parts_after_some_own_tiles_and_after_each_foreign_one(took_own):
    left, since = 0, LOOK_AFTER
    for own in took_own:
        looked = left <= 0
        assert looked == (since >= LOOK_AFTER)
        left = until_look(left, own)
        since = LOOK_AFTER if not own else 1 if looked else since + 1


def test_concurrent_threads_lose_no_tile_and_never_share_one():
    words, hints, places = empty()
    threads, each = 6, 3_000
    busy = np.zeros(TILES, np.int64)

    def push_on(number):
        """Repeatedly wake a tile and take one; return the number of tiles taken."""
        rng, taken = np.random.default_rng(number), 0
        for _ in range(each):
            wake(words, hints, places, int(rng.integers(4 * GROUP)), int(rng.integers(UNREACHED)), number)
            tile, _word = take_any(words, hints, places)
            if tile != NONE:
                busy[tile] += 1
                assert busy[tile] == 1
                busy[tile] -= 1
                let_go(words, hints, places, tile)
                taken += 1
        return taken

    with ThreadPoolExecutor(threads) as pool:
        assert all(taken > 0 for taken in pool.map(push_on, range(threads)))
    while (tile := take_any(words, hints, places)[0]) != NONE:
        let_go(words, hints, places, tile)
    assert (words == IDLE).all()
    assert (hints == IDLE).all()
