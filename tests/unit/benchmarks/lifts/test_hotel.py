"""The bench of lifts measures what it says: robots ride, one at a time or together, and never too many."""

import pytest

from benchmarks.lifts.command import least_wait
from benchmarks.lifts.hotel import FirstCome, Hotel, SharedLifts, simulate

BUSY = Hotel(robots=10, lifts=1, capacity=3, seconds=600.0)


def test_robots_that_share_a_car_reach_more_goals_than_one_a_trip():
    shared, first = simulate(BUSY, SharedLifts, 1), simulate(BUSY, FirstCome, 1)
    assert (max(shared.boarded.values()), max(first.boarded.values())) == (3, 1)
    assert shared.goals > 1.2 * first.goals > 0.0


def test_a_run_of_a_seed_is_the_same_again():
    assert simulate(BUSY, SharedLifts, 2) == simulate(BUSY, SharedLifts, 2)


def test_robots_of_a_lift_that_breaks_take_the_other():
    hotel = Hotel(robots=10, seconds=600.0, breaks_at=200.0)
    result = simulate(hotel, SharedLifts, 1)
    assert 0.0 < result.rerouted <= 5.0
    assert result.longest_open < 300.0


def test_no_wait_is_below_the_bound():
    result = simulate(BUSY, SharedLifts, 3)
    mean = sum(result.waits) / len(result.waits)
    assert mean > least_wait(Hotel(robots=1), 60.0) == pytest.approx(3.0)
