import numpy as np
import pytest

from ppaas.mapping.edge_information import CLOSURE_FLOOR, STEP_FLOOR, edge_information


def test_directions_are_turned_into_the_frame_of_the_first_node():
    information = np.array([(100.0, 0.0, 0.0, 1e4, 0.0, 1e4)])
    found = edge_information(np.array([(1.0, 2.0, np.pi / 2.0)]), information, (1e-6, 1e-6, 1e-6), correlation=1.0)
    np.testing.assert_allclose(found[0], np.diag((1e4, 100.0, 1e4)), rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize("floor", [STEP_FLOOR, CLOSURE_FLOOR])
def test_no_edge_is_better_than_its_floor(floor):
    information = np.array([(1e12, 0.0, 0.0, 1e12, 0.0, 1e12)])
    covariance = np.linalg.inv(edge_information(np.array([(1.0, 0.0, 0.3)]), information, floor)[0])
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), floor, rtol=1e-3)


def test_directions_that_are_not_determined_keep_some_information():
    found = edge_information(np.zeros((2, 3)), np.zeros((2, 6)), STEP_FLOOR)
    assert found.shape == (2, 3, 3)
    assert (np.linalg.eigvalsh(found) > 0.0).all()
