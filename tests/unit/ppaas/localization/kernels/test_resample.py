import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.localization.kernels import resample
from tests.reference.driving import localization as twin

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.floats(0.1, 3.0), st.integers(1, 50))
def test_kld_sample_size_agrees_with_the_twin(seed, spread, least):
    rng = np.random.default_rng(seed)
    particles, weights, picks = rng.normal(0.0, spread, (300, 3)), rng.uniform(0.0, 1.0, 300), rng.random(400)
    expected = twin.kld_sample_size(particles, weights, picks, least, 0.05, 0.99)
    assert resample.kld_sample_size(particles, weights, picks, least, 0.05, 0.99) == expected


@given(st.lists(st.floats(0, 1), min_size=1, max_size=50), st.integers(1, 200), st.floats(0, 1, exclude_max=True))
def test_drawn_particles_agree_with_the_twin(weights, count, start):
    weights = np.array(weights) + 1e-6
    weights /= weights.sum()
    drawn = resample.draw_low_variance(weights, count, start)
    assert (drawn == twin.draw_low_variance(weights, count, start)).all()


@given(st.lists(st.floats(0.001, 1), min_size=1, max_size=50), st.integers(1, 200), st.floats(0, 1, exclude_max=True))
def test_particle_is_drawn_in_proportion_to_its_weight_within_one(weights, count, start):
    weights = np.array(weights) / np.sum(weights)
    drawn = np.bincount(resample.draw_low_variance(weights, count, start), minlength=len(weights))
    assert (np.abs(drawn - count * weights) <= 1.0 + 1e-9).all()
