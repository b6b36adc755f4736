import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap.kernels import people
from ppaas.costmap.social_layer import Proxemics
from tests.reference.maps import costmaps

walking = st.tuples(st.floats(-1.0, 3.0), st.floats(-1.0, 3.0), st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
proxemics = st.builds(
    Proxemics, st.floats(20.0, 250.0), st.floats(0.01, 0.3), st.floats(1.0, 30.0), st.sampled_from([0.0, 1.0, 5.0])
)


@given(seed=st.integers(0, 10_000), walkers=st.lists(walking, max_size=3), how=proxemics)
def test_raised_costs_agree_with_the_twin(seed, walkers, how):
    random = np.random.default_rng(seed)
    costs = random.choice(np.array([0, 0, 0, 30, 252, 254, 255], np.uint8), (24, 30))
    expected, got = costmaps.raised(costs, walkers, 0.08, how), costs.copy()
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
