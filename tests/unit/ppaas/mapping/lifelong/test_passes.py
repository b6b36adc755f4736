import numpy as np

from ppaas.mapping.lifelong.passes import divided_passes, mileage


def test_mileage_counts_distances_and_turns():
    poses = np.array([(0.0, 0.0, 0.0), (3.0, 4.0, 0.0), (3.0, 4.0, 1.0)])
    np.testing.assert_allclose(mileage(poses), (0.0, 5.0, 5.5))


def test_a_place_is_passed_again_after_some_distance():
    assert divided_passes(np.array([0.0, 0.5, 1.0, 8.0, 8.5, 20.0]), 6.0).tolist() == [0, 0, 0, 1, 1, 2]
    assert divided_passes(np.array([3.0]), 6.0).tolist() == [0]
