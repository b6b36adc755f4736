import numpy as np
import pytest
from hypothesis import given
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
    simd.store(out, 128, simd.least(x, y))
    simd.store(out, 160, simd.shift_right(x, simd.both(y, simd.splat(31))))
    simd.store(out, 192, simd.shift_left(x, simd.both(y, simd.splat(31))))
    return simd.unlike(x, y), simd.less(x, y)


@njit
def of_one(a, chosen, number, out):
    x = simd.load(a, 0)
    simd.store(out, 0, simd.where(chosen, x, simd.ramp()))
    simd.store(out, 32, simd.from_left(x, number))
    simd.store(out, 64, simd.from_right(x, number))
    simd.store(out, 96, simd.least_up_to(x))
    simd.store(out, 128, simd.least_from(x))
    simd.store(out, 160, simd.sum_up_to(x))
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
def of_runs(a, runs, out):
    x = simd.load(a, 0)
    below = runs[0], runs[1], runs[2], runs[3], runs[4]
    above = runs[5], runs[6], runs[7], runs[8], runs[9]
    simd.store(out, 0, simd.least_up_to_in(x, *below))
    simd.store(out, 32, simd.least_from_in(x, *above))


@njit
def of_octets(octets, number):
    return simd.bytes_below(octets, 1, number), simd.bytes_unlike(octets, 1, number)


def lanes(truths):
    return sum(1 << lane for lane in range(32) if truths[lane])


@given(ROWS, ROWS)
def test_operations_on_two_rows_work_lane_by_lane(a, b):
    out = np.empty(224, np.uint32)
    assert of_two(a, b, out) == (lanes(a != b), lanes(a < b))
    expected = [a + b, a - b, a * b, a & b, np.minimum(a, b), a >> (b & 31), a << (b & 31)]
    assert out.reshape(7, 32).tolist() == [row.tolist() for row in expected]


@given(ROWS, SETS, st.integers(0, 2**32 - 1))
def test_operations_on_one_row_equal_those_of_numpy(a, chosen, number):
    out = np.empty(192, np.uint32)
    assert of_one(a, chosen, number, out) == a.min()
    expected = [
        np.where([chosen >> lane & 1 for lane in range(32)], a, np.arange(32)),
        [number, *a[:-1]],
        [*a[1:], number],
        np.minimum.accumulate(a),
        np.minimum.accumulate(a[::-1])[::-1],
        np.cumsum(a, dtype=np.uint32),
    ]
    assert out.reshape(6, 32).tolist() == [list(map(int, row)) for row in expected]


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


@given(hnp.arrays(np.uint8, 34, elements=st.integers(0, 255)), st.integers(0, 255))
def test_bytes_are_compared_with_a_number(octets, number):
    inner = octets[1:33]
    assert of_octets(octets, number) == (lanes(inner < number), lanes(inner != number))


def run_around(free, lane):
    """Return begin and end of the run of free lanes that contains a lane; a blocked lane is a run of its own."""
    first = last = lane
    while free >> lane & 1 and first > 0 and free >> (first - 1) & 1:
        first -= 1
    while free >> lane & 1 and last < 31 and free >> (last + 1) & 1:
        last += 1
    return first, last


@given(ROWS, SETS)
def test_prefix_minima_of_runs_do_not_cross_their_borders(a, free):
    around = [run_around(free, lane) for lane in range(32)]
    reaches = [
        [lane - first for lane, (first, _) in enumerate(around)],
        [last - lane for lane, (_, last) in enumerate(around)],
    ]
    runs = np.array([lanes([each >= most for each in reach]) for reach in reaches for most in (1, 2, 4, 8, 16)])
    out = np.empty(64, np.uint32)
    of_runs(a, runs, out)
    expected = [[a[first : lane + 1].min() for lane, (first, _) in enumerate(around)],
                [a[lane : last + 1].min() for lane, (_, last) in enumerate(around)]]  # fmt: skip
    assert out.reshape(2, 32).tolist() == expected
