"""Beliefs about the floor at which a lift stands."""

import math

import pytest

from ppaas.buildings.riding.air import GAS, height_between
from ppaas.buildings.riding.floor_belief import SURE, FloorBelief
from ppaas.errors import InvalidInput

LEVELS = {"L1": 0.0, "L2": 4.0, "L3": 8.0, "L4": 12.0}


def at(height: float, ground: float = 101_325.0) -> float:
    """Return the pressure at a height [Pa]."""
    return ground * math.exp(-height / GAS)


def test_neither_the_order_nor_the_word_of_the_lift_is_trusted_alone() -> None:
    belief = FloorBelief(LEVELS, "L1", "L3")
    assert belief.likeliest == "L3" and belief.known is None
    for _ in range(100):
        belief.lift_names("L3")
    assert belief.known is None, "the same word again tells nothing more"
    assert belief.probabilities()["L3"] < SURE
    belief.lift_names("roof")
    assert belief.likeliest == "L3"


def test_a_barometer_confirms_the_lift_or_contradicts_it() -> None:
    belief = FloorBelief(LEVELS, "L1", "L3")
    belief.lift_names("L3")
    belief.pressure(at(0.0), 100.0)
    belief.pressure(at(8.2), 130.0)
    assert belief.known == "L3"
    belief.pressure(at(4.1), 131.0)
    assert belief.known == "L2", "the lift says L3, but the robot has risen by 4 m"


def test_after_a_long_wait_the_weather_counts() -> None:
    belief = FloorBelief(LEVELS, "L1", "L2")
    belief.lift_names("L2")
    belief.pressure(at(0.0), 0.0)
    belief.pressure(at(7.9), 1800.0)
    assert belief.known is None


def test_scans_decide_where_the_lift_is_silent() -> None:
    belief = FloorBelief(LEVELS, "L4", "L1")
    scans = 0
    while belief.known is None and scans < 20:
        belief.scan({"L1": 2.0, "L2": 5.0, "L3": 1.0, "elsewhere": 99.0})
        scans += 1
    assert belief.known == "L2" and 2 <= scans <= 6
    assert sum(belief.probabilities().values()) == pytest.approx(1.0)


def test_floors_that_look_alike_stay_unknown_rather_than_wrong() -> None:
    belief = FloorBelief(LEVELS, "L1", "L3")
    for _ in range(100):
        belief.scan(dict.fromkeys(LEVELS, 9.0))
    assert belief.known is None and belief.likeliest == "L3"


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(InvalidInput, match="does not stop at floor 'roof', but at L1, L2"):
        FloorBelief(LEVELS, "L1", "roof")
    belief = FloorBelief(LEVELS, "L1", "L3")
    for pressure in (0.0, float("nan"), 1e9):
        with pytest.raises(InvalidInput, match="pressure of the air"):
            belief.pressure(pressure, 0.0)
    assert height_between(at(0.0), at(10.0)) == pytest.approx(10.0)
