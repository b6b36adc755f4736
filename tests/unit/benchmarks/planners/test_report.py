"""What was measured stands between the marks of a page, and nothing else of the page changes."""

from pathlib import Path

import pytest
from rich.progress import Progress

from benchmarks.commands import suite as bench_suite
from benchmarks.planners import machine, report, scaling, suite
from ppaas.errors import InvalidInput

PAGE = f"# Page\n\n{report.BEGIN}\nold\n{report.END}\n\nafter\n"
SCENARIO = {
    "map": "arena", "planner": "jps", "queries": 130, "wrong": 0, "mean_us": 12.25, "p50_us": 10.0, "p99_us": 40.0,
    "index_seconds": 0.5, "index_bytes": 2_000_000,
}  # fmt: skip
LENGTHS = {"cells": 9, "length_m": [1.0, 2.0], "seconds": {"dijkstra, 1 thread": [0.001, 0.002]}, "cpus": 2}


def test_what_was_measured_is_between_the_marks(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(PAGE)
    (tmp_path / "images").mkdir()
    report.write(page, {"scenarios": [SCENARIO], "lengths": [LENGTHS]})
    text = page.read_text()
    assert text.startswith(f"# Page\n\n{report.BEGIN}\n") and text.endswith(f"{report.END}\n\nafter\n")
    assert "old" not in text
    assert "| arena | jps | 130 | 0 | 12.2 | 10.0 | 40.0 | 0.5 | 2 |" in text
    assert "| 2.0 | 2 |" in text and "](images/planners-lengths.png)" in text
    assert (tmp_path / "images" / "planners-lengths.png").exists()
    report.write(page, {})
    assert page.read_text() == f"# Page\n\n{report.BEGIN}\n\n{report.NOTHING}\n\n{report.END}\n\nafter\n"


@pytest.mark.parametrize("text", ["", report.BEGIN, f"{report.END} {report.BEGIN}"])
def test_a_page_without_marks_is_left_alone(tmp_path: Path, text: str) -> None:
    (tmp_path / "page.md").write_text(text)
    with pytest.raises(InvalidInput, match="no place"):
        report.write(tmp_path / "page.md", {})
    assert (tmp_path / "page.md").read_text() == text
    with pytest.raises(InvalidInput, match="cannot read"):
        report.write(tmp_path / "none.md", {})


def test_what_is_kept_is_read_again(tmp_path: Path) -> None:
    file = tmp_path / "measured.json"
    assert report.read(file) == {}
    report.keep(file, {"lengths": [LENGTHS]})
    assert report.read(file) == {"lengths": [LENGTHS]}
    file.write_text("[1]")
    with pytest.raises(InvalidInput, match="is not a file of"):
        report.read(file)
    with pytest.raises(InvalidInput, match="cannot write"):
        report.keep(tmp_path / "none" / "measured.json", {})


def test_every_part_that_can_be_named_is_measured() -> None:
    assert set(bench_suite.PARTS) == set(suite.PARTS)


def test_a_suite_measures_real_maps_and_every_part_can_be_rendered(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suite, "ROS_MAPS", ("tb3_sandbox.yaml",))
    monkeypatch.setattr(suite, "PREPARED", ("jps",))
    monkeypatch.setattr(suite, "SAMPLED", ("dijkstra",))
    monkeypatch.setattr(suite, "QUICK_SAMPLE", 2)
    options = suite.PlannerSuiteOptions(data, ("fields", "scaling", "scenarios"), quick=True)
    with Progress(disable=True) as progress:
        measured = dict(suite.measure(options, progress))
    assert list(measured) == ["machine", "fields", "scaling", "scenarios"]
    scenes = list((data / "movingai").glob("*/*.scen"))
    assert {told["map"] for told in measured["scenarios"]} == {file.name.removesuffix(".map.scen") for file in scenes}
    assert {(told["planner"], told["queries"], told["wrong"]) for told in measured["scenarios"]} == {
        ("jps", 2, 0), ("dijkstra", 2, 0),
    }  # fmt: skip
    text = report.render(measured)
    assert "| tb3_sandbox | 137,448 | 1 |" in text and "| empty | 1 |" in text
    assert "A quick run" in text and "| 2 of 950 |" in text


def test_how_many_times_faster_than_others_is_told_with_what_was_aimed_at() -> None:
    told = {
        "grid": "random 20 % 4096²", "reached": 1000, "seconds": {"1": 2e-6, "2": 1e-6},
        "ns_per_cell": {"1": 2.0, "2": 1.0}, "again_seconds": {"1": 2e-6, "2": 1e-6},
        "beside": {"navfn": 2e-5}, "left_out": {"tcod": "not installed"},
    }  # fmt: skip
    text = report.render({"fields": [told]})
    assert "| random 20 % 4096² | 1 | 10 |  | 7.2 × navfn, 33 × tcod | 20 |  |" in text
    assert "| random 20 % 4096² | 2 | 20 |  | 13 × navfn, 60 × tcod | 20 |  |" in text
    assert "- tcod on random 20 % 4096²: not installed" in text


def test_a_map_whose_index_takes_too_long_is_left_out_of_the_scenarios(
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
    assert {tuple(told["left_out"]) for told in scenarios} == {("jps",)}
    assert "arena2" in report.render({"scenarios": scenarios})
    assert "arena2" in report.render({"scenarios": [{**SCENARIO, "of": 130}, *scenarios]})


@pytest.mark.parametrize(("load", "warned"), [(0.2, False), (1.5, True)])
def test_what_was_measured_on_a_busy_machine_says_so(
    load: float, warned: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(machine.os, "getloadavg", lambda: (load, 0.0, 0.0))
    text = report.render({"machine": [machine.describe() | {"quick": False}]})
    assert text.startswith("Measured on ") and ("not suitable for comparison" in text) == warned


def test_the_spread_is_the_most_over_the_least_of_what_is_large() -> None:
    with Progress(disable=True) as progress:
        told = scaling.measure(["empty"], [64, 512, 600], [1], progress)
    _, first, second = told["ns_per_cell"]["empty"]["1"]
    assert told["spread"]["empty"]["1"] == max(first, second) / min(first, second)


def test_a_folder_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with Progress(disable=True) as progress, pytest.raises(InvalidInput, match="--data"):
        list(suite.measure(suite.PlannerSuiteOptions(tmp_path / "none"), progress))
