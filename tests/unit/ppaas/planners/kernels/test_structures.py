"""Structures of the kernels: bits in words, an indexed heap, and prefetching."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from ppaas.planners.kernels import bits
from ppaas.planners.kernels.indexed_heap import drop, put
from ppaas.planners.kernels.prefetch import fetch, fetch_to_l2

LINES = st.integers(1, (1 << 200) - 1).map(lambda number: [number >> bit & 1 for bit in range(200)])


def words_of(line):
    padded = np.zeros(-(-len(line) // 64) * 64 + 64, np.uint8)
    padded[: len(line)] = line
    return np.packbits(padded, bitorder="little").view(np.uint64)


@given(LINES, st.data())
def test_next_set_bit_is_found_in_both_directions(line, data):
    words, ones = words_of(line), np.flatnonzero(line)
    at = data.draw(st.integers(0, int(ones[-1])))
    assert bits.first_from(words, at) == ones[ones >= at][0]
    at = data.draw(st.integers(int(ones[0]), len(line) - 1))
    assert bits.last_until(words, at) == ones[ones <= at][-1]


@given(LINES, st.data())
def test_single_bits_and_triples_are_read(line, data):
    words = words_of(line)
    at = data.draw(st.integers(1, len(line) - 2))
    assert bits.is_set(words, at) == line[at]
    assert bits.three_at(words, at) == line[at - 1] + 2 * line[at] + 4 * line[at + 1]


@pytest.mark.parametrize("at", [1, 62, 63, 64, 65, 127, 128])
def test_triple_may_span_two_words(at):
    words = words_of([True] * 200)
    assert bits.three_at(words, at) == 7


CELLS = 12
ORDERS = st.lists(st.tuples(st.integers(0, CELLS - 1), st.none() | st.tuples(st.integers(0, 4), st.integers(0, 4))))


@given(ORDERS)
def test_first_key_is_always_the_smallest(orders):
    keys, cells, places = np.zeros((CELLS + 2, 2)), np.zeros(CELLS + 2, np.int32), np.zeros(CELLS, np.int32)
    size, twin = 0, {}
    for cell, key in orders:
        if key is None:
            size = drop(keys, cells, places, size, cell)
            twin.pop(cell, None)
        else:
            size = put(keys, cells, places, size, cell, float(key[0]), float(key[1]))
            twin[cell] = key
        assert size == len(twin)
        assert {int(c): tuple(k) for c, k in zip(cells[1 : size + 1], keys[1 : size + 1], strict=True)} == twin
        assert all(cells[places[c]] == c for c in twin)
        assert not twin or tuple(keys[1]) == min(twin.values())
        assert np.count_nonzero(places) == size


@njit
def _sum_up(numbers, ahead):
    total = 0
    for i in range(len(numbers)):
        fetch(numbers, i + ahead)
        fetch_to_l2(numbers, i + ahead)
        total += numbers[i]
    return total


@pytest.mark.parametrize("ahead", [0, 5, 10**12, -(10**12)])
def test_prefetching_changes_no_number_and_accepts_any_index(ahead):
    numbers = np.arange(100, dtype=np.int32)
    numbers.flags.writeable = False
    assert _sum_up(numbers, np.int64(ahead)) == 4950
