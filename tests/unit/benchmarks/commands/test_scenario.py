"""``ppaas bench scenario``: JSON, table, and errors."""

from pathlib import Path

import pytest

from robots.cli.main import main
from tests.unit.benchmarks.commands.conftest import RunBench


def test_the_json_contains_statistics_and_index_size(map_: Path, run_bench: RunBench) -> None:
    answer = run_bench("scenario", f"{map_}.scen", "--map", str(map_), "--planner", "dijkstra", "--limit", "1")
    assert set(answer) == {
        "planner", "queries", "wrong", "mean_us", "p50_us", "p99_us", "index_seconds", "index_bytes",
    }  # fmt: skip
    assert (answer["planner"], answer["queries"], answer["wrong"]) == ("dijkstra", 1, 0)


def test_the_map_of_a_scenario_is_found_beside_it(map_: Path, run_bench: RunBench) -> None:
    assert run_bench("scenario", f"{map_}.scen")["wrong"] == 0


def test_the_default_output_is_a_table(capsys: pytest.CaptureFixture[str], map_: Path) -> None:
    assert main(["bench", "scenario", f"{map_}.scen"]) == 0
    heading, row = (line.split("  ") for line in capsys.readouterr().out.splitlines())
    assert (heading[0].strip(), row[0].strip()) == ("planner", "dijkstra")


@pytest.mark.parametrize(
    ("arguments", "slug"),
    [
        (["scenario", "none.scen"], "invalid-map"),
    ],
)
def test_a_missing_scenario_is_refused(capsys: pytest.CaptureFixture[str], arguments: list[str], slug: str) -> None:
    assert main(["bench", *arguments]) == 1
    assert capsys.readouterr().err.strip().startswith(f"ppaas: {slug}: ")
