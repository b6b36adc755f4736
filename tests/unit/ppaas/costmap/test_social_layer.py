"""Costs near people, and obstacles that move."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap.kernels import people
from ppaas.costmap.moving_obstacles import MovingObstacle, swept_discs
from ppaas.costmap.social_layer import PersonNearby, Proxemics
from ppaas.errors import InvalidParameter
from tests.reference.maps import costmaps as twin
from tests.support.world import grids


def test_defaults_are_those_of_ros():
    assert Proxemics() == Proxemics(amplitude=77.0, covariance=0.25, cutoff=10.0, factor=5.0)


@pytest.mark.parametrize(
    "wrong",
    [
        {"amplitude": 253.0},
        {"amplitude": 0.0},
        {"covariance": -1.0},
        {"cutoff": math.nan},
        {"factor": -0.1},
        {"group_amplitude": 253.0},
    ],
)
def test_invalid_parameters_are_refused_by_name(wrong):
    with pytest.raises(InvalidParameter, match=next(iter(wrong))):
        Proxemics(**wrong)


def test_add_returns_whether_a_cost_was_raised():
    costmap = grids.of(np.zeros((40, 40), np.uint8), 0.1)
    assert not Proxemics().add(costmap, [])
    assert not Proxemics().add(costmap, [PersonNearby(20.0, 20.0)])
    assert not Proxemics(amplitude=5.0).add(costmap, [PersonNearby(2.05, 2.05)])
    assert Proxemics().add(costmap, [PersonNearby(2.05, 2.05)])
    assert costmap.data[20, 20] == 77
    # Radius at which the cost falls to the cutoff.
    reach = math.sqrt(2.0 * 0.25 * math.log(77.0 / 10.0))
    assert costmap.data[20, 20 + math.floor(reach / 0.1)] >= 10
    assert costmap.data[20, 20 + math.ceil(reach / 0.1)] == 0


def test_costs_between_people_who_talk_are_higher_than_around_one():
    costmap = grids.of(np.zeros((40, 40), np.uint8), 0.1)
    assert Proxemics().between().add(costmap, [PersonNearby(2.05, 2.05)])
    assert costmap.data[20, 20] == 200


walking = st.tuples(st.floats(-1.0, 3.0), st.floats(-1.0, 3.0), st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
proxemics = st.builds(
    Proxemics, st.floats(20.0, 250.0), st.floats(0.01, 0.3), st.floats(1.0, 30.0), st.sampled_from([0.0, 1.0, 5.0])
)


@given(seed=st.integers(0, 10_000), walkers=st.lists(walking, max_size=3), how=proxemics)
def test_raised_costs_agree_with_the_twin(seed, walkers, how):
    random = np.random.default_rng(seed)
    costs = random.choice(np.array([0, 0, 0, 30, 252, 254, 255], np.uint8), (24, 30))
    expected, got = twin.raised(costs, walkers, 0.08, how), costs.copy()
    count = people.raise_around(
        got, np.array(walkers, dtype=float).reshape(-1, 4), 0.08, how.amplitude, how.covariance, how.cutoff, how.factor
    )
    # Costs very close to an integer or to the cutoff may be rounded either way.
    assert np.abs(got.astype(int) - expected).max() <= (1 if walkers else 0) or _at_the_cutoff(got, expected, how)
    assert (got >= costs).all()
    assert count >= np.count_nonzero(got != costs)


def _at_the_cutoff(got, expected, how):
    differs = np.abs(got.astype(int) - expected) > 1
    return (np.abs(np.maximum(got, expected)[differs].astype(float) - how.cutoff) <= 1.0).all()


def test_people_far_away_raise_no_costs():
    costs = np.zeros((10, 10), np.uint8)
    assert (
        people.raise_around(
            costs, np.array([[1e300, -1e300, 1.0, 1.0], [9.0, 9.0, 0.0, 0.0]]), 0.05, 77.0, 0.25, 10.0, 5.0
        )
        == 0
    )


def test_warm_runs():
    people.warm()


FAR = (50.0, 50.0, 0.2)
movers = st.builds(
    MovingObstacle,
    st.floats(-3.0, 3.0),
    st.floats(-3.0, 3.0),
    st.floats(-2.0, 2.0),
    st.floats(-2.0, 2.0),
    st.floats(0.1, 0.5),
)


@given(mover=movers, seconds=st.floats(0.0, 2.0), at=st.floats(0.0, 1.0))
def test_the_discs_cover_the_swept_area(mover, seconds, at):
    discs = list(swept_discs([mover], seconds, FAR))
    there = mover.after(at * seconds)
    assert min(math.hypot(there.x - x, there.y - y) for x, y, _ in discs) <= 0.5 * mover.radius + 1e-9
    assert discs[0] == (mover.x, mover.y, mover.radius)
    assert {radius for *_, radius in discs} == {mover.radius}


@given(mover=movers, seconds=st.floats(0.0, 2.0))
def test_future_discs_do_not_touch_the_robot(mover, seconds):
    robot = (0.0, 0.0, 0.2)
    for x, y, radius in list(swept_discs([mover], seconds, robot))[1:]:
        assert math.hypot(x, y) > radius + 0.2


@pytest.mark.parametrize("still", [MovingObstacle(1.0, 2.0, 0.0, 0.0, 0.3), MovingObstacle(1.0, 2.0, 1.0, 0.0, 0.0)])
def test_obstacle_at_rest_or_without_radius_is_one_disc(still):
    assert list(swept_discs([still], 1.0, FAR)) == [(1.0, 2.0, still.radius)]
