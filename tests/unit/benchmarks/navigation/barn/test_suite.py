import pytest

from benchmarks.navigation.barn.run import BarnOptions, BarnResult, jobs_of, measure, summary
from tests.support.world import barn


def test_results_do_not_depend_on_the_number_of_processes() -> None:
    worlds = [barn.world(9), barn.world(3, (-1.0, 7.0))]
    done: list[int] = []
    one, two = (measure(worlds, BarnOptions(1, "mppi", "nominal", 1, jobs), lambda: done.append(1)) for jobs in (1, 2))
    assert one == two
    assert [result.world for result in one] == [9, 3]
    assert len(done) == 4


def test_every_world_is_run_the_requested_number_of_times() -> None:
    jobs = jobs_of([barn.world(9), barn.world(3)], BarnOptions(2, "dwa", "hard", 5, 1))
    assert [(job.world.world, job.run, job.seed) for job in jobs] == [(9, 0, 5), (9, 1, 5), (3, 0, 5), (3, 1, 5)]


def test_the_summary_aggregates_all_runs() -> None:
    results = [
        BarnResult(1, 0, "success", 5.0, 5.0, 0.2),
        BarnResult(1, 1, "success", 20.0, 5.0, 0.1),
        BarnResult(2, 0, "collision", 3.0, 5.0, -0.01),
        BarnResult(2, 1, "timeout", 100.0, 5.0, 0.3),
    ]
    assert summary(results) == {
        "worlds": 2, "runs": 4, "success": 0.5, "collision": 0.25, "timeout": 0.25,
        "metric": pytest.approx((0.5 + 0.25) / 4), "at_over_ot": 2.5, "min_clearance": -0.01,
    }  # fmt: skip
    assert summary(results[2:])["at_over_ot"] is None
