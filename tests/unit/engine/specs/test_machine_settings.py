"""Validation and use of the settings of a machine."""

import math
from typing import Any

import pytest

from engine.specs.machine_settings import (
    MOST_CONTAINERS,
    MOST_LABELS,
    MOST_OVERSUBSCRIPTION,
    MachineSettings,
    check_settings,
    labels_text,
)
from ppaas.errors import InvalidParameter
from tests.support.engine.placing import machine, spec


@pytest.mark.parametrize(
    "fields",
    [
        {"max_containers": 0},
        {"max_containers": MOST_CONTAINERS},
        {"oversubscription": 0.5},
        {"oversubscription": MOST_OVERSUBSCRIPTION},
        {"max_memory": 1},
        {"labels": {"zone": "a", "gpu.vendor": "none"}},
    ],
)
def test_valid_settings_are_accepted(fields: dict[str, Any]) -> None:
    assert check_settings(MachineSettings(**fields)) == MachineSettings(**fields)


@pytest.mark.parametrize(
    ("fields", "named"),
    [
        ({"max_containers": -1}, "max_containers"),
        ({"max_containers": MOST_CONTAINERS + 1}, "max_containers"),
        ({"oversubscription": 0.0}, "oversubscription"),
        ({"oversubscription": -4.0}, "oversubscription"),
        ({"oversubscription": math.nan}, "oversubscription"),
        ({"oversubscription": math.inf}, "oversubscription"),
        ({"oversubscription": MOST_OVERSUBSCRIPTION + 1.0}, "oversubscription"),
        ({"max_memory": 0}, "max_memory"),
        ({"labels": {"": "a"}}, "label"),
        ({"labels": {"zone": ""}}, "label"),
        ({"labels": {"zone": "a b"}}, "label"),
        ({"labels": {"zone=": "a"}}, "label"),
        ({"labels": {f"l{number}": "a" for number in range(MOST_LABELS + 1)}}, "labels"),
    ],
)
def test_invalid_setting_is_refused_by_name(fields: dict[str, Any], named: str) -> None:
    with pytest.raises(InvalidParameter, match=named):
        check_settings(MachineSettings(**fields))


def test_labels_are_formatted_for_messages() -> None:
    assert labels_text({"zone": "a", "gpu": "yes"}) == "gpu=yes, zone=a"


def test_capacity_is_limited_by_memory() -> None:
    small = machine("m", 4)  # has one GiB
    assert (small.capacity, small.room) == (8.0, 4.0)
    for number in range(2):
        small.place(spec(f"c{number}", 3.5))
    assert small.room == 1.0
    small.settings = MachineSettings(max_memory=1 << 29)
    assert small.capacity == 4.0 and not small.has_room(spec("c", 0.25))
    small.settings = MachineSettings(max_memory=1 << 40)
    assert small.capacity == 8.0, "no more than it has"


def test_an_oversubscription_of_one_shares_no_core() -> None:
    assert machine("m", 2, settings=MachineSettings(oversubscription=1.0)).capacity == 2.0


def test_administrator_labels_override_agent_labels() -> None:
    labelled = machine("m", labels={"zone": "a", "gpu": "no"}, settings=MachineSettings({"zone": "b"}))
    assert labelled.all_labels == {"zone": "b", "gpu": "no"}
    assert labelled.suits({"zone": "b"}) and labelled.suits({})
    assert not labelled.suits({"zone": "a"}) and not labelled.suits({"zone": "b", "disk": "fast"})
