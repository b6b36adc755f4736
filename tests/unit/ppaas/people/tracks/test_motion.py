"""Motion models of people: constant velocity for a short time, a stop after a long one."""

import math

import pytest

from ppaas.people.tracks.filter_bank import MotionModel, MotionParameters

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
