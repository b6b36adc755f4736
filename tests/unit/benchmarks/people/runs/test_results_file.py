"""Stored results of runs."""

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.people.runs import results_file
from ppaas.errors import InvalidInput
from tests.unit.benchmarks.people.runs.results import JOB, RESULT


def test_a_stored_result_is_found_by_the_settings_of_its_run(tmp_path: Path) -> None:
    path = tmp_path / "runs.jsonl"
    assert results_file.read(path) == {}
    results_file.append(path, JOB, RESULT)
    results_file.append(path, replace(JOB, seed=1), RESULT)
    known = results_file.read(path)
    assert known[results_file.key(JOB)] == RESULT
    assert results_file.key(replace(JOB, policy="single")) not in known


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("no result\n")
    with pytest.raises(InvalidInput, match="name another file"):
        results_file.read(path)


def test_a_file_that_cannot_be_written_is_refused_before_the_first_run(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"cannot write results to .*: No such file or directory"):
        results_file.check(tmp_path / "missing" / "runs.jsonl")
    results_file.check(tmp_path / "runs.jsonl")
    assert results_file.read(tmp_path / "runs.jsonl") == {}
