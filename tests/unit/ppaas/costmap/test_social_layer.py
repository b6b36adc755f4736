import math

import numpy as np
import pytest

from ppaas.costmap.social_layer import PersonNearby, Proxemics
from ppaas.errors import InvalidParameter
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
