"""Checks of parameters: types, finite numbers and bounds."""

import math
from typing import Any

import pytest

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters, check_numbers, check_scalar, read_parameters


@pytest.mark.parametrize(("kind", "value"), [(bool, True), (int, -3), (float, 0.5), (float, 7)])
def test_a_value_of_its_type_passes(kind: type, value: Any) -> None:
    check_scalar("speed", value, kind)


@pytest.mark.parametrize(
    ("kind", "value", "said"),
    [
        (bool, 1, "true or false"),
        (bool, "yes", "true or false"),
        (int, 1.0, "type int"),
        (int, True, "type int"),
        (float, True, "type float"),
        (float, "1", "type float"),
        (float, None, "type float"),
        (float, math.nan, "finite"),
        (float, -math.inf, "finite"),
    ],
)
def test_another_is_refused_by_name(kind: type, value: Any, said: str) -> None:
    with pytest.raises(InvalidParameter, match=f"speed must be .*{said}"):
        check_scalar("speed", value, kind)


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
def test_numbers_within_their_bounds_pass(given: dict[str, Any]) -> None:
    read_parameters(Numbers, "numbers", given)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"rate": 0.0}, "rate must be above 0, not 0.0"),
        ({"count": -1}, "count must be at least 0, not -1"),
        ({"offset": math.inf}, "offset must be finite, not inf"),
        ({"rate": math.nan}, "rate must be finite, not nan"),
        ({"rate": True}, "rate"),
        ({"count": 0.5}, "count"),
        ({"speed": 1.0}, "speed"),
    ],
)
def test_numbers_out_of_bounds_are_refused_by_name(given: dict[str, Any], text: str) -> None:
    with pytest.raises(InvalidParameter, match=text):
        read_parameters(Numbers, "numbers", given)
