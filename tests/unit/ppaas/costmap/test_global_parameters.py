"""Parameters of the global costmap."""

import math

import pytest

from ppaas.costmap.global_parameters import CostParameters, GlobalCostmapParameters
from ppaas.errors import InvalidParameter
from ppaas.parameters import read_parameters


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({"inflation_radius": -0.1}, "inflation_radius must be from 0 to 100, not -0.1"),
        ({"inflation_radius": 101}, "inflation_radius must be from 0 to 100"),
        ({"inflation_radius": math.nan}, "inflation_radius"),
        ({"cost_scaling_factor": math.inf}, "cost_scaling_factor must be from 0 to 1e"),
        ({"lethal_cost_threshold": 0}, "lethal_cost_threshold must be from 1 to 100, not 0"),
        ({"lethal_cost_threshold": 101}, "lethal_cost_threshold"),
        ({"lethal_cost_threshold": 65.5}, "lethal_cost_threshold"),
        ({"inflation_radius": "wide"}, "inflation_radius"),
        ({"inflation": 0.5}, "known: cost_scaling_factor, footprint, inflation_radius, lethal_cost_threshold, robot_"),
    ],
)
def test_parameters_out_of_range_are_refused_by_name(given, reason):
    with pytest.raises(InvalidParameter, match=reason):
        read_parameters(GlobalCostmapParameters, "global_costmap", given)


def test_only_costs_that_differ_from_the_defaults_are_changed():
    assert GlobalCostmapParameters(robot_radius=0.3, inflation_radius=0.55).changed == {}
    given = read_parameters(GlobalCostmapParameters, "global_costmap", {"inflation_radius": 1, "robot_radius": 1})
    assert given.changed == {"inflation_radius": 1.0}
    assert given.costs == CostParameters(inflation_radius=1.0)
