"""Figures and rows of runs."""

from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from benchmarks.people import coordination
from benchmarks.people.options import PeopleOptions
from benchmarks.people.runs.job import append_result
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
