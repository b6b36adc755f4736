import numpy as np
import pytest

from ppaas.controllers.mppi import draw
from ppaas.controllers.mppi_parameters import MppiParameters


@pytest.mark.parametrize("batch_size", [8, 9, 600])
def test_first_deviation_is_zero_and_others_are_mirrored_pairs(batch_size):
    noise = draw(MppiParameters(batch_size=batch_size))
    assert noise.shape == (batch_size, 30, 2)
    assert not noise[0].any()
    pairs = noise[2 : batch_size // 2 * 2].reshape(-1, 2, 30, 2)
    assert (pairs[:, 0] == pairs[:, 1] * (1.0, -1.0)).all()


def test_noise_has_the_given_deviation_and_depends_on_the_seed():
    parameters = MppiParameters(batch_size=4000, vx_std=0.3, wz_std=0.9)
    noise = draw(parameters)
    assert noise.std(axis=(0, 1)) == pytest.approx((0.3, 0.9), rel=0.03)
    assert (noise == draw(parameters)).all()
    assert (noise != draw(MppiParameters(batch_size=4000, vx_std=0.3, wz_std=0.9, seed=1))).any()


def test_consecutive_deviations_are_correlated():
    noise = draw(MppiParameters(batch_size=4000))[2:, :, 0]
    assert np.corrcoef(noise[:, 10], noise[:, 11])[0, 1] == pytest.approx(0.8, abs=0.05)
