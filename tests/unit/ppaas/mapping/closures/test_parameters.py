import pytest

from ppaas.errors import InvalidParameter
from ppaas.mapping.closures.parameters import ClosureParameters


def test_defaults_are_valid():
    assert ClosureParameters().drift.heading_walk > 0.0


@pytest.mark.parametrize(
    "given",
    [
        {"least_ratio": 1.5},
        {"submap_travel": 0.0},
        {"loop_search_space_resolution": float("nan")},
        {"loop_match_minimum_chain_size": 6},
    ],
)
def test_parameter_out_of_range_is_refused_by_name(given):
    with pytest.raises(InvalidParameter, match=next(iter(given))):
        ClosureParameters(**given)
