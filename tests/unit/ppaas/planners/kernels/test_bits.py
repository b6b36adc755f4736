import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.planners.kernels import bits

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
