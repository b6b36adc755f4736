"""Parameters of costmap filters."""

import math

import pytest

from ppaas.errors import InvalidParameter
from ppaas.nodes.map_server.costmap_filters import filter_masks


def test_filter_masks_lists_the_masks_of_enabled_filters():
    keepout, speed = {"filter_mask": "kept"}, {"filter_mask": "slow", "base": 100, "multiplier": -1}
    assert filter_masks({"keepout_filter": keepout, "speed_filter": speed, "dwa": {}}) == {
        "keepout_filter": "kept",
        "speed_filter": "slow",
    }
    assert filter_masks({"keepout_filter": keepout | {"enabled": False}, "speed_filter": {}}) == {}
    assert filter_masks({}) == {}


@pytest.mark.parametrize(
    ("name", "parameters", "why"),
    [
        ("keepout_filter", {"mask": "kept"}, "known: enabled, filter_mask"),
        ("keepout_filter", {"filter_mask": 3}, "filter_mask"),
        ("speed_filter", {"filter_mask": "slow", "type": 0}, "type"),
        ("speed_filter", {"multiplier": math.inf}, "multiplier must be finite"),
        ("speed_filter", [], "speed_filter"),
    ],
)
def test_invalid_parameters_are_refused_by_name(name, parameters, why):
    with pytest.raises(InvalidParameter, match=why):
        filter_masks({name: parameters})
