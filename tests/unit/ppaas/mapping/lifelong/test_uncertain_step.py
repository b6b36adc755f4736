"""Uncertain steps, compared with samples."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.mapping.lifelong.uncertain_step import UncertainStep
from ppaas.planar_poses import compose, inverse
from tests.support.budget import examples

COVARIANCE = np.array([(4e-4, 1e-4, 2e-5), (1e-4, 9e-4, -3e-5), (2e-5, -3e-5, 1e-4)])
poses = st.tuples(*[st.floats(-5.0, 5.0)] * 2, st.floats(-3.1, 3.1)).map(np.array)


def samples(step: UncertainStep, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).multivariate_normal(step.measurement, step.covariance, 10_000)


def assert_spread(found: UncertainStep, drawn: np.ndarray) -> None:
    off = drawn - found.measurement
    off[:, 2] = (off[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    expected = np.cov(off.T)
    scale = np.sqrt(np.diag(expected))
    assert np.abs(found.covariance - expected).max(initial=0.0) <= 0.08 * scale.max() ** 2
    assert np.all(np.abs(off.mean(axis=0)) <= 0.05 * scale + 1e-3)


@settings(max_examples=examples(20))
@given(poses, poses)
def test_steps_one_after_the_other_have_the_covariance_of_samples(first, second):
    one, two = UncertainStep(first, COVARIANCE), UncertainStep(second, 2.0 * COVARIANCE)
    assert_spread(one.then(two), compose(samples(one, 1), samples(two, 2)))


@settings(max_examples=examples(20))
@given(poses)
def test_a_step_back_has_the_covariance_of_samples(measurement):
    step = UncertainStep(measurement, COVARIANCE)
    assert_spread(step.inverted(), inverse(samples(step, 3)))
    np.testing.assert_allclose(step.inverted().inverted().covariance, COVARIANCE, atol=1e-12)
