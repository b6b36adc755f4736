import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.mapping.graph.robust_weights import CovarianceScaling, FixedWeights, truncated_weights

distances = st.floats(0.0, 1e6)


@given(distances)
def test_weights_of_scaling_are_the_derivative_of_its_loss(chi2):
    rule, step = CovarianceScaling(np.array([True]), 5.0), 1e-4 * (1.0 + chi2)
    ahead, behind = rule.loss(np.array([chi2 + step])), rule.loss(np.array([max(0.0, chi2 - step)]))
    slope = (ahead - behind) / (step + min(step, chi2))
    assert rule.weights(np.array([chi2]))[0] == pytest.approx(slope, rel=1e-3, abs=1e-4)


def test_odometry_keeps_its_weight():
    rule = CovarianceScaling(np.array([False, True]), 5.0)
    assert rule.weights(np.array([1000.0, 1000.0])) == pytest.approx([1.0, (10.0 / 1005.0) ** 2])


def test_fixed_weights_weigh_the_loss():
    rule = FixedWeights(np.array([1.0, 0.5]))
    assert rule.loss(np.array([3.0, 4.0])) == 5.0


@given(distances, st.floats(1e-6, 100.0))
def test_truncated_weights_fall_from_one_to_zero(chi2, control):
    weight, farther = truncated_weights(np.array([chi2, chi2 + 0.1]), 9.0, control)
    assert 0.0 <= farther <= weight <= 1.0


def test_truncated_weights_become_a_step():
    assert truncated_weights(np.array([8.9, 9.1]), 9.0, 1e4).tolist() == [1.0, 0.0]
    assert truncated_weights(np.array([8.9, 900.0]), 9.0, 1e-6)[1] == pytest.approx(1e-4, rel=0.1)
