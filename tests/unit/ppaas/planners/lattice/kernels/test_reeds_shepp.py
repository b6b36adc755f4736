import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.planners.lattice.kernels.dubins import dubins
from ppaas.planners.lattice.kernels.reeds_shepp import FAMILIES, MAX_PIECES, reeds_shepp, spell
from tests.reference.planners import curves as twin

NUMBERS = st.floats(-8.0, 8.0)


GOALS = st.tuples(NUMBERS, NUMBERS, st.floats(-7.0, 7.0))


WEIGHTS = st.floats(1.0, 4.0)


def pieces_of(word):
    pieces = np.empty((MAX_PIECES, 2))
    count = spell(word, pieces)
    return pieces[:count].tolist()


def assert_ends_at(pieces, goal):
    x, y, heading = twin.end_of(pieces)
    assert math.hypot(x - goal[0], y - goal[1]) < 1e-6
    assert twin.same_heading(heading, goal[2]) < 1e-6


def weighed(pieces, reverse, turn):
    return sum(abs(s) * (turn if curvature else 1) * (reverse if s < 0 else 1) for curvature, s in pieces)


def seen_from(goal, other):
    """Return the pose ``other`` in the mirrored frame of the goal; for the origin it is the goal of the way back."""
    (x, y, theta), (ox, oy, otheta) = goal, other
    c, s = math.cos(theta), math.sin(theta)
    return c * (ox - x) + s * (oy - y), c * (oy - y) - s * (ox - x), otheta - theta


@given(GOALS, WEIGHTS, WEIGHTS)
def test_curve_ends_at_its_goal_and_its_cost_is_right(goal, reverse, turn):
    word = reeds_shepp(*goal, reverse, turn)
    assert_ends_at(pieces_of(word), goal)
    assert word.cost == pytest.approx(weighed(pieces_of(word), reverse, turn), abs=1e-9)
    assert {curvature for curvature, _ in pieces_of(word)} <= {-1.0, 0.0, 1.0}


@given(GOALS)
def test_length_is_symmetric_and_between_line_and_dubins(goal):
    length = reeds_shepp(*goal, 1.0, 1.0).cost
    assert length == pytest.approx(reeds_shepp(*seen_from(goal, (0, 0, 0)), 1.0, 1.0).cost, abs=1e-6)
    assert math.hypot(*goal[:2]) - 1e-9 <= length <= dubins(*goal, 1.0).cost + 1e-9


@given(GOALS)
def test_mirrored_goals_have_equal_lengths(goal):
    x, y, theta = goal
    length = reeds_shepp(*goal, 1.0, 1.0).cost
    assert length == pytest.approx(reeds_shepp(x, -y, -theta, 1.0, 1.0).cost, abs=1e-9)
    assert length == pytest.approx(reeds_shepp(-x, y, -theta, 1.0, 1.0).cost, abs=1e-9)


def test_lengths_agree_with_the_twin():
    rng = np.random.default_rng(4)
    for _ in range(3):
        goal = (*rng.uniform(-3.0, 3.0, 2).tolist(), rng.uniform(-math.pi, math.pi))
        forward = twin.shortest(twin.DUBINS_WORDS, goal, swap_gears=False)
        both = twin.shortest(twin.REEDS_SHEPP_WORDS, goal, swap_gears=True)
        assert dubins(*goal, 1.0).cost == pytest.approx(forward, abs=1e-6)
        assert reeds_shepp(*goal, 1.0, 1.0).cost == pytest.approx(both, abs=1e-6)


@pytest.mark.parametrize(
    ("goal", "length"),
    [
        ((0.0, 0.0, 0.0), 0.0),
        ((5.0, 0.0, 0.0), 5.0),
        ((-5.0, 0.0, 0.0), 5.0),
        ((0.0, 0.0, math.pi), math.pi),  # three arcs of 60° each
        ((0.0, 2.0, math.pi), math.pi),  # half a circle
        ((1.0, 1.0, math.pi / 2), math.pi / 2),
    ],
)
def test_known_lengths_are_right(goal, length):
    assert reeds_shepp(*goal, 1.0, 1.0).cost == pytest.approx(length, abs=1e-9)


def test_all_word_families_occur():
    rng = np.random.default_rng(2)
    goals = rng.uniform(-4.0, 4.0, (3_000, 3))
    assert {reeds_shepp(*goal, 1.0, 1.0).family for goal in goals.tolist()} == set(range(FAMILIES))
