"""Checks of scalar parameters: types, finite numbers and bounds."""

import math
from typing import Any

import pytest

from ppaas.errors import InvalidParameter
from ppaas.parameters import check_scalar


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
