"""``ppaas bench slam``."""

import argparse
from pathlib import Path
from typing import Any

import pytest

from benchmarks.commands import slam
from benchmarks.mapping import suite
from benchmarks.mapping.run import SlamJob
from ppaas.errors import InvalidInput


class _Progress:
    """Progress display that counts."""

    def __init__(self) -> None:
        self.done = 0

    def add_task(self, name: str, total: int) -> int:
        return 0

    def advance(self, task: int) -> None:
        self.done += 1


def jobs_of(*words: str) -> list[SlamJob]:
    parser = argparse.ArgumentParser()
    slam.configure(parser)
    return slam._jobs(parser.parse_args(list(words)))


def test_an_office_is_mapped_with_a_fast_and_a_slow_laser_by_default() -> None:
    assert [job.name for job in jobs_of()] == ["office 0", "office 0, sweep 0.1 s"]
    assert len(jobs_of("--offices", "3")) == 6
    assert [job.name for job in jobs_of("--offices", "0", "--corridors")] == ["corridors 0"]


def test_logs_and_those_of_a_folder_are_mapped(tmp_path: Path) -> None:
    raw = tmp_path / "laser" / "raw"
    raw.mkdir(parents=True)
    for name in ("b.clf.bz2", "a.clf", "a.relations"):
        (raw / name).touch()
    (tmp_path / "c.log").touch()
    found = jobs_of(str(tmp_path / "c.log"), "--data", str(tmp_path), "--offices", "0")
    assert [job.name for job in found] == ["c", "a", "b"]


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (("missing.log",), "no log missing.log"),
        (("--data", "missing"), "has no log"),
        (("--offices", "0"), "nothing to map"),
    ],
)
def test_missing_logs_are_refused(words: tuple[str, ...], error: str) -> None:
    with pytest.raises(InvalidInput, match=error):
        jobs_of(*words)


def test_results_become_json_and_a_table(monkeypatch: pytest.MonkeyPatch) -> None:
    errors = {"mean_m": 0.002, "std_m": 0.001, "max_m": 0.01, "mean_deg": 0.02, "std_deg": 0.01, "max_deg": 0.1}
    result: dict[str, Any] = {
        "log": "office 0", "scans": 100, "metres": 30.0, "minutes": 1.5, "closures": 4, "cpu_s": 1.0,
        "times_real_time": 90.0, "seconds": {"tracking": 0.05}, "peak_mib": 200.0, "own_mib": 20.0,
        "stages": {"tracking": errors | {"mean_m": 0.1}, "polish": errors | {"absolute_m": 0.004}},
    }  # fmt: skip
    monkeypatch.setattr(suite, "measure", lambda jobs, processes, done: [done() or result for _ in jobs])
    parser, progress = argparse.ArgumentParser(), _Progress()
    slam.configure(parser)
    measured = slam.measure(parser.parse_args([]), progress)  # type: ignore[arg-type]
    assert measured.result == {"logs": [result, result]}
    assert progress.done == 2
    row = measured.rows[0]
    assert row["relations m"] == "0.0020 ± 0.0010 (max 0.01)"
    assert row["by stage m"] == "0.1000 → 0.0020"
    assert row["ms a scan"] == "0.50"
    assert row["MiB (own)"] == "200 (20)"
