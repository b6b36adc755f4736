"""Runs of the localization bench, and their summary."""

import pytest

from benchmarks.localization.run import Kind, LocalizationJob, LocalizationResult, drive, measure, summary
from ppaas.maps.generate import office

GRID = office(seed=1, width=12.0, height=10.0)


def job(kind: Kind, metres: float, run: int = 0) -> LocalizationJob:
    return LocalizationJob(GRID, kind, metres, {}, seed=5, run=run)


@pytest.mark.parametrize("kind", ["kidnap", "global"])
def test_a_lost_robot_is_found(kind: Kind) -> None:
    result = drive(job(kind, 12.0))
    assert not result.lost
    assert result.found is not None
    assert result.found < 10.0
    assert result.error < 0.15


@pytest.mark.parametrize("run", [4, 16])
def test_a_robot_in_a_jam_is_not_lost(run: int) -> None:
    result = drive(LocalizationJob(office(seed=1), "jam", 2.0, {}, seed=1, run=run, people=10))
    assert not result.lost
    assert result.found == 0.0
    assert result.worst < 0.3


def test_results_do_not_depend_on_the_number_of_processes() -> None:
    jobs = [job("track", 3.0, run) for run in (0, 1)]
    done: list[int] = []
    one, two = (measure(jobs, processes, lambda: done.append(1)) for processes in (1, 2))
    poses = [[(result.run, result.error, result.worst, result.metres) for result in results] for results in (one, two)]
    assert poses[0] == poses[1]
    assert [result.run for result in one] == [0, 1]
    assert len(done) == 4
    assert all(result.metres == pytest.approx(3.0, abs=0.2) and not result.lost for result in one)


def test_the_summary_aggregates_all_runs() -> None:
    results = [
        LocalizationResult(0, 0.02, 0.01, 0.1, 0.1, lost=False, found=4.0, metres=15.0, update=0.001),
        LocalizationResult(1, 0.04, 0.01, 0.2, 0.1, lost=False, found=12.0, metres=15.0, update=0.003),
        LocalizationResult(2, 9.0, 3.0, 9.0, 3.0, lost=True, found=None, metres=15.0, update=0.002),
    ]
    totals = summary(results)
    assert (totals["runs"], totals["metres"], totals["lost"]) == (3, 45.0, 1)
    assert (totals["error_cm"], totals["error_deg"]) == (3.0, 0.573)
    assert (totals["worst_cm"], totals["worst_deg"]) == (20.0, 5.7)
    assert (totals["found_within_10_m"], totals["median_found_m"], totals["update_ms"]) == (0.333, 8.0, 2.0)
    assert summary(results[2:])["error_cm"] is None
