"""Stored results of runs."""

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.people.runs.job import append_result, check_results, key_of, read_results
from ppaas.errors import InvalidInput
from tests.unit.benchmarks.people.runs.results import JOB, RESULT


def test_a_stored_result_is_found_by_the_settings_of_its_run(tmp_path: Path) -> None:
    path = tmp_path / "runs.jsonl"
    assert read_results(path) == {}
    append_result(path, JOB, RESULT)
    append_result(path, replace(JOB, seed=1), RESULT)
    known = read_results(path)
    assert known[key_of(JOB)] == RESULT
    assert key_of(replace(JOB, policy="single")) not in known


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("no result\n")
    with pytest.raises(InvalidInput, match="name another file"):
        read_results(path)


def test_a_file_that_cannot_be_written_is_refused_before_the_first_run(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"cannot write results to .*: No such file or directory"):
        check_results(tmp_path / "missing" / "runs.jsonl")
    check_results(tmp_path / "runs.jsonl")
    assert read_results(tmp_path / "runs.jsonl") == {}
