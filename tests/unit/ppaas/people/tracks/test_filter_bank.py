"""Filters of many people at once: those who walk are led, those who stand are averaged."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.people.tracks.filter_bank import FilterBank, MotionModel, MotionParameters, squared_distances
from tests.support.budget import examples

NOISE = 0.05**2 * np.eye(2)


def followed(velocity: tuple[float, float], steps: int = 40, seconds: float = 0.2) -> FilterBank:
    """Return the filter of a person who was seen at a velocity, with noise."""
    bank, random = FilterBank(), np.random.default_rng(1)
    bank.add([(0.0, 0.0)], [NOISE])
    for step in range(1, steps):
        bank.predict(seconds)
        seen = step * seconds * np.array(velocity) + random.normal(0.0, 0.05, 2)
        bank.update([0], [seen], [NOISE])
    return bank


def test_a_person_who_walks_is_predicted_at_his_velocity() -> None:
    bank = followed((1.0, -0.5))
    assert bank.weights[0, 0] > 0.8
    bank.predict(1.0)
    mean, _ = bank.states()
    assert mean[0, :2] == pytest.approx([8.8 - 0.15, -4.4 + 0.07], abs=0.35)


def test_a_person_who_stands_is_averaged_and_stays() -> None:
    bank = followed((0.0, 0.0))
    assert bank.weights[0, 1] > 0.8
    mean, covariance = bank.states()
    assert np.hypot(*mean[0, :2]) < 0.05
    assert np.sqrt(covariance[0, 0, 0]) < 0.05
    bank.predict(2.0)
    assert np.hypot(*bank.states()[0][0, :2]) < 0.2


def test_people_are_independent_of_each_other() -> None:
    both, alone = FilterBank(), FilterBank()
    both.add([(0.0, 0.0), (9.0, 9.0)], [NOISE, NOISE])
    alone.add([(9.0, 9.0)], [NOISE])
    for bank, row in ((both, 1), (alone, 0)):
        bank.predict(0.3)
        bank.update([row], [(9.2, 9.1)], [NOISE])
    both.keep([1])
    assert both.states()[0] == pytest.approx(alone.states()[0])


@settings(max_examples=examples(25), deadline=None)
@given(st.lists(st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(0.0, 3.0)), min_size=1, max_size=12))
def test_covariances_stay_positive_and_weights_sum_to_one(seen: list[tuple[float, float, float]]) -> None:
    bank = FilterBank()
    bank.add([(0.0, 0.0)], [NOISE])
    for x, y, seconds in seen:
        bank.predict(seconds)
        bank.update([0], [(x, y)], [NOISE])
    assert (np.linalg.eigvalsh(bank.states()[1][0]) > 0.0).all()
    assert bank.weights.sum() == pytest.approx(1.0)


def test_an_uncertainty_grows_without_measurements() -> None:
    bank = followed((1.0, 0.0))
    sizes = []
    for _ in range(5):
        bank.predict(1.0)
        sizes.append(np.trace(bank.states()[1][0][:2, :2]))
    assert sizes == sorted(sizes)


def test_the_squared_distance_is_that_of_mahalanobis() -> None:
    covariance = np.array([[0.5, 0.2], [0.2, 0.4]])
    off = np.array([0.3, -0.7])
    assert squared_distances(off, covariance) == pytest.approx(off @ np.linalg.inv(covariance) @ off)


MODEL = MotionModel(memory=4.0, speed=1.0)


def test_over_a_short_time_the_velocity_is_constant() -> None:
    reach, decay, position, mixed, velocity = MODEL.moments(0.01)
    push = 2.0 * MODEL.speed**2 / MODEL.memory
    assert (reach, decay) == (pytest.approx(0.01, rel=1e-2), pytest.approx(1.0, abs=1e-2))
    assert velocity == pytest.approx(push * 0.01, rel=1e-2)
    assert mixed == pytest.approx(push * 0.01**2 / 2.0, rel=1e-2)
    assert position == pytest.approx(push * 0.01**3 / 3.0, rel=2e-2)


def test_over_a_long_time_the_person_stops_and_the_speed_stays_that_of_a_person() -> None:
    reach, decay, _, _, velocity = MODEL.moments(100.0)
    assert (reach, decay) == (pytest.approx(MODEL.memory), pytest.approx(0.0, abs=1e-6))
    assert velocity == pytest.approx(MODEL.speed**2)


def test_two_predictions_are_as_one() -> None:
    reach, decay, position, mixed, velocity = MODEL.moments(0.7)
    assert MODEL.moments(1.4)[0] == pytest.approx(reach + decay * reach)
    twice = position + 2.0 * reach * mixed + reach**2 * velocity + position
    assert MODEL.moments(1.4)[2] == pytest.approx(twice)


def test_after_a_long_time_the_person_walks_or_stands_with_even_chances() -> None:
    assert MotionParameters().switching(1e3) == pytest.approx(0.5)
    assert MotionParameters(stays=5.0).switching(0.1) == pytest.approx(0.1 / 5.0, rel=0.05)
    assert math.isclose(MotionParameters().switching(0.0), 0.0)
