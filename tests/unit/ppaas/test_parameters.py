"""Checks of parameters: types, finite numbers and bounds."""

import math
from typing import Any

import pytest

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, check_numbers, read_parameters


class Numbers(Parameters, frozen=True, kw_only=True):
    """Parameters with numbers that must be above 0, at least 0, and any."""

    rate: float = 1.0
    count: int = 0
    offset: float = 0.0
    name: str = "any"
    enabled: bool = False

    def __post_init__(self) -> None:
        check_numbers(self, positive=("rate",), signed=("offset",))


@pytest.mark.parametrize("given", [{}, {"rate": 2}, {"count": 3}, {"offset": -1.5}, {"name": "-1", "enabled": True}])
def test_numbers_within_bounds_are_accepted(given: dict[str, Any]) -> None:
    read_parameters(Numbers, "numbers", given)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"rate": 0.0}, "rate must be above 0, not 0.0"),
        ({"count": -1}, "count must be at least 0, not -1"),
        ({"offset": math.inf}, "offset must be finite, not inf"),
        ({"rate": math.nan}, "rate must be finite, not nan"),
        ({"rate": True}, "rate"),
        ({"rate": "1"}, "rate"),
        ({"rate": None}, "rate"),
        ({"count": 0.5}, "count"),
        ({"count": True}, "count"),
        ({"enabled": 1}, "enabled"),
        ({"enabled": "yes"}, "enabled"),
        ({"speed": 1.0}, "speed"),
    ],
)
def test_numbers_out_of_bounds_are_refused_by_name(given: dict[str, Any], text: str) -> None:
    with pytest.raises(InvalidParameter, match=text):
        read_parameters(Numbers, "numbers", given)
