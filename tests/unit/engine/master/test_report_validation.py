"""Tests of the validation of machine reports."""

import math
from typing import Any

import msgspec
import pytest

from engine.master.report_validation import LEAST_MEMORY, MOST_CORES, check_heartbeat, check_registration
from engine.protocols.control_link import ContainerLoad, Heartbeat, Register
from engine.protocols.versions import OWN, Protocols
from ppaas.errors import Conflict, InvalidInput, InvalidParameter
from tests.support.engine.engine_links import register
from tests.support.engine.placing import machine


def registration(**fields: Any) -> Register:
    return msgspec.structs.replace(register(), **fields)


def test_valid_registration_is_accepted() -> None:
    check_registration(registration(cores=MOST_CORES, memory=LEAST_MEMORY, labels={"zone": "a"}, network=1e8))


@pytest.mark.parametrize(("spoken", "agreed"), [(None, 1), (OWN, OWN.newest), (Protocols(OWN.newest, 9), OWN.newest)])
def test_a_machine_of_another_release_is_accepted_by_its_protocols(spoken: Protocols | None, agreed: int) -> None:
    release = "0.2.0" if spoken is None else "9.9.9"
    assert check_registration(registration(release=release, protocols=spoken)) == agreed


@pytest.mark.parametrize("release", ["", "0.0.9", "x" * 1000])
def test_machine_of_another_release_without_protocols_is_refused(release: str) -> None:
    with pytest.raises(Conflict, match="release") as refused:
        check_registration(registration(release=release))
    assert len(str(refused.value)) < 300


@pytest.mark.parametrize(
    "fields",
    [
        {"machine": ""},
        {"machine": "../m1"},
        {"machine": "m" * 65},
        {"cores": 0},
        {"cores": -2},
        {"cores": MOST_CORES + 1},
        {"memory": 0},
        {"memory": 1 << 60},
        {"network": math.nan},
        {"network": -1.0},
        {"labels": {"no label": "a"}},
    ],
    ids=str,
)
def test_invalid_registration_is_refused(fields: dict[str, Any]) -> None:
    with pytest.raises(InvalidInput):
        check_registration(registration(**fields))


def test_full_usage_is_a_valid_heartbeat() -> None:
    check_heartbeat(machine("m1"), Heartbeat(2.0, 1 << 30, [ContainerLoad("c1", 1.0, 1 << 20)], 1e6, {"m2": 0.001}))


@pytest.mark.parametrize(
    "heartbeat",
    [
        Heartbeat(math.nan, 0, []),
        Heartbeat(-1.0, 0, []),
        Heartbeat(0.0, (1 << 30) + 1, []),
        Heartbeat(0.0, -1, []),
        Heartbeat(0.0, 0, [], math.inf),
        Heartbeat(0.0, 0, [], 0.0, {"m2": -0.1}),
        Heartbeat(0.0, 0, [], 0.0, {"m2": math.nan}),
        Heartbeat(0.0, 0, [ContainerLoad("c1", math.inf, 0)]),
        Heartbeat(0.0, 0, [ContainerLoad("c1", 0.0, 1 << 31)]),
    ],
    ids=str,
)
def test_impossible_heartbeat_is_refused(heartbeat: Heartbeat) -> None:
    with pytest.raises(InvalidParameter, match="'m1' reports"):
        check_heartbeat(machine("m1"), heartbeat)


def test_counts_that_nobody_makes_are_refused() -> None:
    with pytest.raises(InvalidParameter, match="nothing is counted"):
        check_heartbeat(machine("m1"), Heartbeat(0.0, 0, [], work={"coffee": 3}))
