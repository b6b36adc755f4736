"""``ppaas bench index``: JSON, table, and errors."""

from pathlib import Path

import pytest

from robots.cli.main import main
from tests.unit.benchmarks.commands.conftest import RunBench


def test_the_json_contains_the_times_per_number_of_threads(map_: Path, run_bench: RunBench) -> None:
    answer = run_bench("index", "--map", str(map_), "--tiles", "3", "--threads", "1,2")
    assert set(answer) == {
        "grid", "planner", "seconds", "bytes", "queries", "wrong", "mean_us", "p50_us", "p99_us",
        "plans", "map_us", "seen_us", "seen_wrong", "cpus",
    }  # fmt: skip
    assert (answer["grid"], answer["planner"], answer["wrong"]) == ("3 by 3 times a", "hub_labels", 0)
    assert set(answer["seconds"]) == {"1", "2"}


@pytest.mark.parametrize(
    ("arguments", "slug"),
    [
        (["index", "--empty", "9", "--planner", "dijkstra"], "invalid-parameter"),
    ],
)
def test_a_planner_without_an_index_is_refused(
    capsys: pytest.CaptureFixture[str], arguments: list[str], slug: str
) -> None:
    assert main(["bench", *arguments]) == 1
    assert capsys.readouterr().err.strip().startswith(f"ppaas: {slug}: ")
