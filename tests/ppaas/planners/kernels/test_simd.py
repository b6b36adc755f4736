import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numba import njit

from ppaas.planners.kernels import simd

ROWS = hnp.arrays(np.uint32, 32, elements=st.integers(0, 2**32 - 1) | st.integers(0, 3))
SETS = st.integers(0, 2**32 - 1)


@njit
def of_two(a, b, out):
    x, y = simd.load(a, 0), simd.load(b, 0)
    simd.store(out, 0, simd.add(x, y))
    simd.store(out, 32, simd.subtract(x, y))
    simd.store(out, 64, simd.multiply(x, y))
    simd.store(out, 96, simd.both(x, y))
    simd.store(out, 128, simd.either(x, y))
    simd.store(out, 160, simd.least(x, y))
    simd.store(out, 192, simd.shift_right(x, simd.both(y, simd.splat(31))))
    simd.store(out, 224, simd.shift_left(x, simd.both(y, simd.splat(31))))
    return simd.unlike(x, y), simd.less(x, y)


@njit
def of_one(a, chosen, number, out):
    x = simd.load(a, 0)
    simd.store(out, 0, simd.where(chosen, x, simd.ramp()))
    simd.store(out, 32, simd.from_left(x, number))
    simd.store(out, 64, simd.from_right(x, number))
    simd.store(out, 96, simd.least_up_to(x))
    simd.store(out, 128, simd.least_from(x))
    return simd.least_of(x)


@njit
def of_bits(bits):
    return simd.first_lane(bits), simd.mirrored(bits)


@njit
def of_bytes(octets, out, kept):
    x = simd.load_bytes(octets, 1)
    simd.store(out, 0, x)
    simd.store_bytes(kept, 1, x)


@njit
def transposed(source, target):
    simd.transpose_block(source, 16, target, 512)


def lanes(truths):
    return sum(1 << lane for lane in range(32) if truths[lane])


@given(ROWS, ROWS)
@settings(deadline=None, max_examples=50)
def test_what_is_done_with_two_rows_is_done_lane_by_lane(a, b):
    out = np.empty(256, np.uint32)
    assert of_two(a, b, out) == (lanes(a != b), lanes(a < b))
    expected = [a + b, a - b, a * b, a & b, a | b, np.minimum(a, b), a >> (b & 31), a << (b & 31)]
    assert out.reshape(8, 32).tolist() == [row.tolist() for row in expected]


@given(ROWS, SETS, st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=50)
def test_what_is_done_with_one_row_is_what_numpy_does(a, chosen, number):
    out = np.empty(160, np.uint32)
    assert of_one(a, chosen, number, out) == a.min()
    expected = [
        np.where([chosen >> lane & 1 for lane in range(32)], a, np.arange(32)),
        [number, *a[:-1]],
        [*a[1:], number],
        np.minimum.accumulate(a),
        np.minimum.accumulate(a[::-1])[::-1],
    ]
    assert out.reshape(5, 32).tolist() == [list(map(int, row)) for row in expected]


@pytest.mark.parametrize("bits", [1, 0x80000000, 0b1011000, 0xFFFFFFFF])
def test_sets_of_lanes_are_read_from_both_ends(bits):
    first, mirrored = of_bits(bits)
    assert first == (bits & -bits).bit_length() - 1
    assert mirrored == int(f"{bits:032b}"[::-1], 2)


def test_bytes_are_widened_and_narrowed():
    octets = np.arange(200, 234, dtype=np.uint8)
    out, kept = np.empty(32, np.uint32), np.zeros(34, np.uint8)
    of_bytes(octets, out, kept)
    assert out.tolist() == list(range(201, 233))
    assert kept.tolist() == [0, *range(201, 233), 0]


def test_a_block_is_transposed_into_its_place():
    source = np.arange(1_024, dtype=np.uint32)
    target = np.zeros(1_024, np.uint32)
    transposed(source, target)
    expected = np.zeros((32, 32), np.uint32)
    expected[16:, :16] = source.reshape(32, 32)[:16, 16:].T
    assert np.array_equal(target.reshape(32, 32), expected)
