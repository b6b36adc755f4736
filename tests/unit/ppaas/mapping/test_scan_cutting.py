import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.mapping.scan_points import without_discs
from ppaas.planar_poses import compose
from tests.support.world.room_scans import scan_at

POSE = Pose2D(1.0, -0.5, 0.7)


def in_map(scan):
    return compose(np.array(POSE), np.column_stack((scan.points, np.zeros(len(scan.points)))))[:, :2]


@given(x=st.floats(-5.0, 7.0), y=st.floats(-4.0, 4.0), radius=st.floats(0.05, 1.5))
def test_only_points_on_the_disc_lose_their_reading(x, y, radius):
    scan = scan_at(POSE)
    cut = without_discs(scan, POSE, np.array([(x, y, radius)]))
    away = np.hypot(*(in_map(scan) - (x, y)).T)
    clear = np.abs(away - radius) > 1e-5
    np.testing.assert_array_equal(cut.valid[clear], (scan.valid & (away > radius))[clear])
    np.testing.assert_array_equal(cut.points[cut.valid], scan.points[cut.valid])
    assert not cut.normals[~cut.valid].any()


def test_a_scan_without_such_points_is_returned_unchanged():
    scan = scan_at(POSE)
    assert without_discs(scan, POSE, np.empty((0, 3))) is scan
    assert without_discs(scan, POSE, np.array([(30.0, 30.0, 1.0)])) is scan


def test_normals_beside_a_cut_are_dropped():
    scan = scan_at(POSE)
    middle = int(np.flatnonzero(scan.valid)[40])
    x, y = in_map(scan)[middle]
    cut = without_discs(scan, POSE, np.array([(x, y, 0.01)]))
    assert not cut.valid[middle]
    assert cut.valid[[middle - 1, middle + 1]].all()
    assert not cut.normals[[middle - 1, middle, middle + 1]].any()
