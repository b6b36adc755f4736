"""The bound of the energy bench is one: no rehearsal exceeds it, and it is right where that is known."""

import argparse

import pytest
from rich.progress import Progress

from benchmarks.energy.bound import PARTS, bound
from benchmarks.energy.command import LEAST, configure, measure
from benchmarks.energy.fleet import ChargingFleet
from ppaas.energy.battery import Battery
from ppaas.energy.sites import Sites
from ppaas.tasks.orders import RobotNow
from ppaas.tasks.reach import SPEED


def fleet(charge: float, gain: float, per_metre: float = 1e-3) -> ChargingFleet:
    robots = {"r": RobotNow((0.0, 0.0, 0.0), battery=Battery(charge, per_metre, 0.0, gain))}
    return ChargingFleet(robots, Sites({"c": (0.0, 0.0, 0.0)}), [(0.0, 0.0, 0.0), (100.0, 0.0, 0.0)], gain)


@pytest.mark.parametrize(
    ("charge", "gain", "expected"),
    [(1.0, 1e-9, 5.0), (1.0, 1.0, 18.0), (0.0, 1e-9, 0.0)],
    ids=["a battery for 1000 m", "time for 3600 m", "no charge"],
)
def test_the_bound_is_what_time_and_charge_allow(
    charge: float, gain: float, expected: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("benchmarks.energy.bound.HANDLING", 0.0)
    monkeypatch.setattr("benchmarks.energy.bound.PER_METRE", 1e-3)
    monkeypatch.setattr("benchmarks.energy.bound.PER_SECOND", 0.0)
    found = bound(fleet(charge, gain), [(0, 1)] * 100, 3600.0 / SPEED, 0.0).tasks
    assert found == pytest.approx(expected, abs=0.6)  # the last way back is not needed


def test_loaded_moves_that_lead_one_way_need_empty_ones_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("benchmarks.energy.bound.HANDLING", 0.0)
    there, both = (bound(fleet(1.0, 1.0), pairs, 1e5, 0.0).tasks for pairs in ([(0, 1)], [(0, 1), (1, 0)]))
    assert both == pytest.approx(2.0 * there, rel=0.02)


def test_a_small_fleet_stays_below_the_bound_and_none_is_stranded() -> None:
    parser = argparse.ArgumentParser()
    configure(parser)
    words = ["--robots", "8", "--chargers", "2", "--hours", "3", "--waiting", "6"]
    measured = measure(parser.parse_args(words), Progress(disable=True))
    assert measured.result["stranded"] == 0, measured.text
    assert 0.6 <= measured.result["ratio"] <= 1.0
    assert measured.status == int(measured.result["ratio"] < LEAST)
    assert measured.result["charges"] > 0
    assert measured.result["longest_wait"] > 0.0


def test_the_time_of_a_task_is_that_of_its_parts() -> None:
    parser = argparse.ArgumentParser()
    configure(parser)
    words = ["--robots", "5", "--chargers", "1", "--hours", "2", "--waiting", "3"]
    result = measure(parser.parse_args(words), Progress(disable=True)).result
    for times, tasks in (("seconds_of_task", result["tasks"]), ("seconds_of_bound", result["bound"])):
        assert tuple(result[times]) == PARTS
        assert sum(result[times].values()) * tasks == pytest.approx(5 * 7200.0, rel=1e-3)
        assert all(seconds >= -0.01 for seconds in result[times].values())
    assert result["seconds_of_task"]["handling"] == pytest.approx(60.0, rel=0.15)
    assert result["seconds_of_bound"]["handling"] == pytest.approx(60.0, rel=1e-3)
