"""Tests of the texts that explain why no machine has capacity."""

import pytest

from engine.master.machine import Machine
from engine.master.queueing import explain_no_machine
from tests.support.engine.placing import machine
from tests.support.engine.specs import robot_request


def test_full_cloud_is_reported_with_the_requested_size() -> None:
    why = explain_no_machine(robot_request(cores=2.0), {"m1": machine("m1")})
    assert why == "no machine has room for a container of 2.0 cores: try again later"


def test_machines_are_not_examined_for_a_request_without_labels(monkeypatch: pytest.MonkeyPatch) -> None:
    def examine(_: Machine) -> dict[str, str]:
        raise AssertionError

    monkeypatch.setattr(Machine, "all_labels", property(examine))
    assert explain_no_machine(robot_request(), {"m1": machine("m1")}).startswith("no machine has room")


def test_machine_with_the_fewest_missing_labels_is_named() -> None:
    machines = {
        name: machine(name, labels=labels)
        for name, labels in (("m1", {}), ("m2", {"a": "1", "b": "2"}), ("m3", {"a": "1"}))
    }
    why = explain_no_machine(robot_request(labels={"a": "1", "b": "2", "c": "3"}), machines)
    assert why == "no machine has the labels a=1, b=2, c=3; 'm2' is closest, but lacks c=3"


def test_label_with_another_value_counts_as_missing() -> None:
    why = explain_no_machine(robot_request(labels={"a": "1"}), {"m1": machine("m1", labels={"a": "2"})})
    assert why.endswith("lacks a=1")
