import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidGraph
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.serialization.quantised_scans import pack_scans, unpack_scans


@given(st.integers(0, 2**32 - 1), st.integers(0, 4), st.integers(1, 30), st.floats(0.01, 1000.0), st.floats(0.0, 1.0))
def test_scans_of_any_size_are_rounded_to_a_part_of_their_reach(seed, count, beams, reach, share):
    scans = random_scans(seed, count, beams, reach, share)
    read = unpack_scans(*pack_scans(scans), beams)
    step = max(2.0**-11, 2.0 ** np.ceil(np.log2(reach / 32767.0)))
    np.testing.assert_array_equal(read.valid, scans.valid)
    np.testing.assert_allclose(read.points, scans.points, atol=0.5001 * step)
    np.testing.assert_allclose(read.normals, scans.normals, atol=8e-4)
    assert pack_scans(read)[1] == pack_scans(unpack_scans(*pack_scans(read), beams))[1]
    again = unpack_scans(*pack_scans(read), beams)
    for stored, given_ in zip(again, read, strict=True):
        np.testing.assert_array_equal(stored, given_)


def test_a_point_too_far_away_is_refused():
    scans = random_scans(1, 1, 3, 10.0, 1.0)
    scans.points[0, 0] = 3e8
    with pytest.raises(InvalidGraph, match="set max_laser_range"):
        pack_scans(scans)


def test_beams_of_an_unknown_state_are_refused():
    exponents, data = pack_scans(random_scans(1, 1, 3, 10.0, 1.0))
    with pytest.raises(InvalidGraph, match="out of range"):
        unpack_scans(exponents, data[:-1] + b"\7", 3)
    with pytest.raises(InvalidGraph, match="out of range"):
        unpack_scans(exponents + np.int8(50), data, 3)


def random_scans(seed, count, beams, reach, share):
    random = np.random.default_rng(seed)
    valid = random.random((count, beams)) < share
    is_open = ~valid & (random.random((count, beams)) < 0.5)  # free up to its point, without a reading
    points = random.uniform(-reach, reach, (count, beams, 2)).astype(np.float32) * (valid | is_open)[..., None]
    angles = random.uniform(-np.pi, np.pi, (count, beams))
    normals = np.stack((np.cos(angles), np.sin(angles)), axis=-1) * (valid & (angles > -1.0))[..., None]
    return ScanPoints(points, normals.astype(np.float32), valid)
