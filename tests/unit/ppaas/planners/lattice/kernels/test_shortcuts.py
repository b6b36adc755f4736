"""Curves and shortcuts of kinematic paths are optimal, and dividing a path does not change it."""

import math

import numpy as np
import pytest
from hypothesis import example, given

from ppaas.planners.lattice.kernels.driving import flat_surface
from ppaas.planners.lattice.kernels.dubins import dubins
from ppaas.planners.lattice.kernels.reeds_shepp import MAX_PIECES, reeds_shepp
from ppaas.planners.lattice.kernels.shortcuts import cut, join, trace
from ppaas.planners.lattice.kernels.steering import LEG, Car, curve
from tests.reference.planners import driving
from tests.reference.planners import lattice as twin
from tests.unit.ppaas.planners.lattice.kernels.test_reeds_shepp import (
    GOALS,
    WEIGHTS,
    assert_ends_at,
    pieces_of,
    weighed,
)

CAR = Car(3.0, True, 72, 2.0, 1.2, 0.0, 3.5, 9.0)


@pytest.mark.parametrize("seed", range(8))
def test_cost_equals_that_of_the_cheapest_chain_of_curves(seed):
    rng = np.random.default_rng(seed)
    costs = np.where(rng.random((30, 30)) < 0.02, 254, rng.integers(0, 60, (30, 30))).astype(np.uint8)
    rates = 1.0 + 0.016 * np.arange(256.0)
    poses = np.column_stack((rng.uniform(4.0, 26.0, (6, 2)), rng.uniform(-3.0, 3.0, 6)))
    along = np.cumsum(rng.uniform(30.0, 60.0, 6)) - 30.0
    world, best = twin.World(costs, rates, CAR), along.copy()
    for at in range(6):
        for to in range(at + 1, 6):
            start, goal = tuple(poses[at].tolist()), tuple(poses[to].tolist())
            curve = twin.cost_of(world, start, twin.curve(CAR, start, goal)[1], 0.0)
            old = along[to] - along[at] if to == at + 1 else math.inf
            best[to] = min(best[to], best[at] + curve, best[at] + old)
    least, origins, counts = along.copy(), np.arange(-1, 5, dtype=np.int32), np.zeros(6, np.int32)
    legs = np.empty((6, MAX_PIECES, LEG))
    surface = flat_surface(costs)._replace(rates=rates)
    for first in (0, 2):
        join(surface, CAR, poses, along, least, origins, legs, counts, first, min(first + 3, 5))
    np.testing.assert_allclose(least, best, atol=1e-5)
    for to in range(1, 6):
        way = legs[to, : counts[to], 5].sum() if counts[to] else along[to] - along[to - 1]
        assert least[to] == pytest.approx(least[origins[to]] + way, abs=1e-5)


def random_legs(rng):
    """Return random successive legs on an empty map, and their ends."""
    pose, legs = (40.0, 40.0, rng.uniform(-3.0, 3.0)), []
    for _ in range(6):
        piece = float(rng.choice([0.0, 1.0 / 3.0, -0.2])), rng.uniform(-8.0, 8.0)
        legs.append((*pose, *piece, abs(piece[1]) * twin.weigh(CAR, piece, piece[0])))
        pose = driving.pose_along(pose, *piece)
    return np.array(legs)


@pytest.mark.parametrize("seed", range(8))
def test_a_divided_path_has_the_same_samples_and_short_parts(seed):
    legs = random_legs(np.random.default_rng(seed))
    surface = flat_surface(np.zeros((90, 90), np.uint8))
    parts = np.empty((100, LEG))
    parts = parts[: cut(surface, CAR, legs, 1.5, parts)]
    assert np.abs(parts[:, 4]).max() < 1.5 + 1.0
    assert np.abs(parts[:, 4]).sum() == pytest.approx(np.abs(legs[:, 4]).sum())
    assert parts[:, 5].sum() == pytest.approx(legs[:, 5].sum())
    whole, cut_up = np.full((200, 3), np.nan), np.full((200, 3), np.nan)
    count = trace(surface, legs, False, whole)
    assert trace(surface, parts, False, cut_up) == count
    np.testing.assert_allclose(cut_up[:count], whole[:count], atol=1e-9)
    expected = [p for x, y, theta, k, s, _ in legs.tolist() for p in driving.points((x, y, theta), k, s, 0.0)]
    np.testing.assert_allclose(whole[:count], expected, atol=1e-9)


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


@given(GOALS, WEIGHTS, WEIGHTS)
def test_curve_is_the_cheapest_word_not_the_shortest(goal, reverse, turn):
    car = Car(1.0, True, 72, reverse, turn, 0.0, 3.5, 9.0)
    cost = curve(car, 0.0, 0.0, 0.0, *goal).cost
    assert cost <= weighed(pieces_of(reeds_shepp(*goal, 1.0, 1.0)), reverse, turn) + 1e-9
    assert cost <= weighed(pieces_of(dubins(*goal, turn)), reverse, turn) + 1e-9
