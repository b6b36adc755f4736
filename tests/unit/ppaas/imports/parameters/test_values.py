"""Values of parameters: numbers as ROS reads them, frames, footprints, text of launch files."""

import math
from typing import Any

import pytest

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters import values


@pytest.mark.parametrize(
    ("convert", "given", "expected"),
    [
        (values.number, 1, 1.0),
        (values.number, "1e-3", 0.001),
        (values.number, " -2.5E+1 ", -25.0),
        (values.magnitude, -0.3, 0.3),
        (values.negated, 0.3, -0.3),
        (values.whole, 20.0, 20),
        (values.whole, "12", 12),
        (values.unless_zero, 0.0, None),
        (values.unless_zero, 0.2, 0.2),
        (values.if_above_zero, 0.2, 0.2),
        (values.if_above_zero, -0.2, None),
        (values.frame, "/robot1/base_link", "robot1/base_link"),
        (values.corners, "[[0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1], [0.2, -0.1]]",
         [[0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1], [0.2, -0.1]]),
        (values.at_most(10.0), 20, 10.0),
        (values.at_least(0.1), 0, 0.1),
        (values.at_least(0.1), -1, -1.0),
        (values.at_least(1, int), 2.5, 2),
        (values.within(1, 10), 1e9, 10),
        (lambda value: values.numbers(value, 3), "[1, 2.5 3]", [1.0, 2.5, 3.0]),
        (lambda value: values.numbers(value, 3), [1, 2.5, 3], [1.0, 2.5, 3.0]),
        (values.one_of({"pkg::Name": "ours"}), "pkg/Name", "ours"),
    ],
)  # fmt: skip
def test_values_are_converted(convert: Any, given: object, expected: object) -> None:
    assert convert(given) == expected


@pytest.mark.parametrize(
    ("convert", "given"),
    [
        (values.number, True),
        (values.number, "fast"),
        (values.number, [1.0]),
        (values.number, math.nan),
        (values.number, 10**400),
        (values.whole, "1e999"),
        (values.times(2.0), 1.7e308),
        (values.number, None),
        (values.above_zero, 0.0),
        (values.unless_zero, -1.0),
        (values.whole, 1.5),
        (values.flag, 1),
        (values.flag, "true"),
        (values.text, 1.0),
        (values.frame, "/"),
        (values.corners, [[0.1, 0.2], [0.3]]),
        (values.corners, [[0.1, 0.2], [0.3, 0.2]]),
        (values.corners, 4),
        (values.one_of({"a": "b"}), "c"),
        (values.within(1, 10), math.inf),
        *((lambda value: values.numbers(value, 3), wrong) for wrong in ([1, 2], "x", [1, 2, True], 3.0, None)),
    ],
)
def test_other_values_are_refused(convert: Any, given: object) -> None:
    with pytest.raises(InvalidParameter, match="must"):
        convert(given)


def test_text_that_a_launch_file_replaces_is_recognized() -> None:
    assert values.is_replaced("$(find-pkg-share mine)/x.yaml", None)
    assert values.is_replaced("<robot_namespace>/base_link", values.frame)
    assert values.is_replaced("KEEPOUT_ZONE_ENABLED", values.flag)
    assert not values.is_replaced("REEDS_SHEPP", values.text)
    assert not values.is_replaced("map", values.frame)
    assert not values.is_replaced(1.0, values.number)


def test_names_are_a_list_or_words() -> None:
    assert values.names_of("scan  cloud") == ["scan", "cloud"]
    assert values.names_of(["scan", 3, "cloud"]) == ["scan", "cloud"]
    assert values.names_of(7) == []
