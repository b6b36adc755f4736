import math

import pytest
from hypothesis import example, given

from ppaas.planners.lattice.kernels.dubins import dubins
from tests.unit.ppaas.planners.lattice.kernels.test_reeds_shepp import (
    GOALS,
    WEIGHTS,
    assert_ends_at,
    pieces_of,
    weighed,
)


@given(GOALS, WEIGHTS)
@example((0.0, 0.0, 5e-324), 1.0)
def test_dubins_curve_ends_at_its_goal_and_never_reverses(goal, turn):
    word = dubins(*goal, turn)
    assert_ends_at(pieces_of(word), goal)
    assert word.cost == pytest.approx(weighed(pieces_of(word), math.inf, turn), abs=1e-9)
    assert all(length >= 0.0 for _, length in pieces_of(word))


@pytest.mark.parametrize(
    ("goal", "length"),
    [
        ((0.0, 0.0, 0.0), 0.0),
        ((5.0, 0.0, 0.0), 5.0),
        ((0.0, 2.0, math.pi), math.pi),
        ((0.0, 0.0, math.pi), 7.0 * math.pi / 3.0),  # 60° left, 300° right, 60° left
        ((0.0, -4.0, math.pi), math.pi + 2.0),  # a quarter, straight, and a quarter more
    ],
)
def test_known_lengths_of_dubins_curves_are_right(goal, length):
    assert dubins(*goal, 1.0).cost == pytest.approx(length, abs=1e-9)


def test_a_turn_rounded_below_zero_is_not_a_full_circle():
    assert dubins(3.0, 0.0, -1e-16, 1.0).cost == pytest.approx(3.0)
    assert dubins(3.0, -1e-17, 1e-17, 1.0).cost == pytest.approx(3.0)
