"""A suite measures every requested part, and reports omitted measurements."""

from pathlib import Path

import pytest
from rich.progress import Progress

from benchmarks.commands.planners import Suite
from benchmarks.planners import report, suite
from ppaas.errors import InvalidInput

SCENARIO = {
    "map": "arena", "planner": "jps", "queries": 130, "wrong": 0, "mean_us": 12.25, "p50_us": 10.0, "p99_us": 40.0,
    "index_seconds": 0.5, "index_bytes": 2_000_000,
}  # fmt: skip


def test_every_known_part_is_measured() -> None:
    assert set(Suite.PARTS) == set(suite.PARTS)


def test_real_maps_are_measured_and_every_part_can_be_rendered(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suite, "ROS_MAPS", ("tb3_sandbox.yaml",))
    monkeypatch.setattr(suite, "PREPARED", ("jps",))
    monkeypatch.setattr(suite, "SAMPLED", ("dijkstra",))
    monkeypatch.setattr(suite, "QUICK_SAMPLE", 2)
    options = suite.PlannerSuiteOptions(data, ("fields", "scaling", "scenarios"), quick=True)
    with Progress(disable=True) as progress:
        measured = dict(suite.measure(options, progress))
    assert list(measured) == ["machine", "fields", "scaling", "scenarios"]
    scenes = list((data / "movingai").glob("*/*.scen"))
    assert {row["map"] for row in measured["scenarios"]} == {file.name.removesuffix(".map.scen") for file in scenes}
    assert {(row["planner"], row["queries"], row["wrong"]) for row in measured["scenarios"]} == {
        ("jps", 2, 0), ("dijkstra", 2, 0),
    }  # fmt: skip
    text = report.render(measured)
    assert "| tb3_sandbox | 137,448 | 1 |" in text and "| empty | 1 |" in text
    assert "A quick run" in text and "| 2 of 950 |" in text


def test_a_map_whose_index_takes_too_long_is_left_out(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "movingai" / "dao").mkdir(parents=True)
    for file in (data / "movingai" / "dao").glob("arena2.*"):
        (tmp_path / "movingai" / "dao" / file.name).symlink_to(file)
    monkeypatch.setattr(suite, "PREPARED", ("jps",))
    monkeypatch.setattr(suite, "SAMPLED", ())
    monkeypatch.setattr(suite, "PATIENCE", -1.0)
    with Progress(disable=True) as progress:
        scenarios = dict(suite.measure(suite.PlannerSuiteOptions(tmp_path, ("scenarios",), quick=True), progress))[
            "scenarios"
        ]
    assert {tuple(row["left_out"]) for row in scenarios} == {("jps",)}
    assert "arena2" in report.render({"scenarios": scenarios})
    assert "arena2" in report.render({"scenarios": [{**SCENARIO, "of": 130}, *scenarios]})


def test_a_missing_folder_is_refused(tmp_path: Path) -> None:
    with Progress(disable=True) as progress, pytest.raises(InvalidInput, match="--data"):
        list(suite.measure(suite.PlannerSuiteOptions(tmp_path / "none"), progress))
