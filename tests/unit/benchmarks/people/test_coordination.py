"""Figures and rows of runs."""

import argparse
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from benchmarks.people import command, coordination, coordinator, suite
from benchmarks.people.options import PeopleOptions
from benchmarks.people.runs.job import DETECTIONS, POLICIES, append_result
from robots.cli.main import main
from tests.unit.benchmarks.people.runs.results import JOB, RESULT

NEAREST = msgspec.structs.replace(RESULT, policy="nearest", flaps=4)


def test_the_rule_of_the_paper_has_bars_and_the_others_are_baselines(tmp_path: Path) -> None:
    keep = tmp_path / "runs.jsonl"
    jobs = (JOB, replace(JOB, policy="nearest"))
    for job, result in zip(jobs, (RESULT, NEAREST), strict=True):
        append_result(keep, job, result)
    done: list[None] = []
    part = coordination.measure(PeopleOptions(jobs, keep=keep), lambda: done.append(None))
    kept = {figure.name: (figure.kept, figure.yardstick) for figure in part.figures}
    assert (kept["paper: count exact"], kept["nearest: count exact"]) == ((True, False), (None, True))
    assert kept["paper: identity switches"] == (False, False)  # 2 per person and ten minutes
    assert [row["policy"] for row in part.rows] == ["paper", "nearest"]
    assert (part.rows[1]["flaps"], len(part.results), len(done)) == ("4", 2, 2)


def test_switches_are_per_person_and_ten_minutes() -> None:
    assert coordination.switches_per_person([RESULT]) == pytest.approx(2.0)
    assert coordination.switches_per_person([msgspec.structs.replace(RESULT, people=0, identity_switches=0)]) == 0.0
    longer = msgspec.structs.replace(RESULT, simulated=900.0)
    assert coordination.switches_per_person([RESULT, longer]) == pytest.approx(1.0)


def test_each_fault_has_a_run_beside_one_without(tmp_path: Path) -> None:
    options = PeopleOptions((JOB,), keep=tmp_path / "runs.jsonl", quick=True)
    jobs = coordination.faulty_jobs(options)
    assert jobs[0].fault == ""
    for job in jobs:
        append_result(tmp_path / "runs.jsonl", job, msgspec.structs.replace(RESULT, fault=job.fault))
    part = coordination.measure_faults(options, lambda: None)
    assert {row["fault"] for row in part.rows} == {"-", "crowd", *(job.fault for job in jobs if job.fault)}
    assert [figure.yardstick for figure in part.figures[:4]] == [True, True, False, False]


def test_the_largest_group_has_the_bar_and_the_baseline(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(coordinator, "GROUPS", ((1, 2), (2, 4)))
    monkeypatch.setattr(coordinator, "QUICK", 3)
    monkeypatch.setattr(coordinator, "FIRST", 1)
    result = coordinator.measure(PeopleOptions(quick=True))
    assert [figure.limit for figure in result.figures] == [None, coordinator.LONGEST, None]
    assert [figure.yardstick for figure in result.figures] == [False, False, True]
    assert [row["robots"] for row in result.rows] == ["1", "2"]
    assert all(each["cycle_p99_ms"] > 0.0 for each in result.results)


def options(*words: str) -> list[tuple[str, str, int, int, int]]:
    """Return the runs that arguments ask for: map, policy, robots, people, seed."""
    parser = argparse.ArgumentParser()
    command.configure(parser)
    jobs = command.options_of(parser.parse_args(words)).jobs
    return [(job.map, job.policy, job.robots, job.people, job.seed) for job in jobs]


def test_the_whole_table_is_the_default() -> None:
    assert len(options()) == 2 * 3 * 3 * 3 * 5


def test_a_part_of_the_table_is_chosen_by_options() -> None:
    chosen = options("--maps", "office", "--policies", "paper", "--robots", "2", "5", "--people", "1", "--seeds", "2")
    assert chosen == [("office", "paper", robots, 1, seed) for robots in (2, 5) for seed in (0, 1)]


def test_the_choices_of_the_command_are_those_of_the_parts() -> None:
    assert (command.PARTS, command.POLICIES, command.DETECTIONS) == (suite.NAMES, POLICIES, DETECTIONS)


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        (["--size", "big"], "WIDTHxHEIGHT"),
        (["--maps", "nowhere.yaml"], "nowhere.yaml"),
        (["--picture", "out.pdf"], "PNG"),
    ],
)
def test_invalid_options_are_refused(capsys: pytest.CaptureFixture[str], wrong: list[str], error: str) -> None:
    assert main(["bench", "people", "--only", "coordination", *wrong]) != 0
    assert error in capsys.readouterr().err
