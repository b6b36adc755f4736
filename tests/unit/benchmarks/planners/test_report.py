"""A report replaces the part of a page between its marks, and nothing else."""

from pathlib import Path

import pytest
from rich.progress import Progress

from benchmarks.planners import report, scaling, suite
from ppaas.errors import InvalidInput

PAGE = f"# Page\n\n{report.BEGIN}\nold\n{report.END}\n\nafter\n"
SCENARIO = {
    "map": "arena", "planner": "jps", "queries": 130, "wrong": 0, "mean_us": 12.25, "p50_us": 10.0, "p99_us": 40.0,
    "index_seconds": 0.5, "index_bytes": 2_000_000,
}  # fmt: skip
LENGTHS = {"cells": 9, "length_m": [1.0, 2.0], "seconds": {"dijkstra, 1 thread": [0.001, 0.002]}, "cpus": 2}


def test_the_report_replaces_the_text_between_the_marks(tmp_path: Path) -> None:
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
def test_a_page_without_marks_is_unchanged(tmp_path: Path, text: str) -> None:
    (tmp_path / "page.md").write_text(text)
    with pytest.raises(InvalidInput, match="no place"):
        report.write(tmp_path / "page.md", {})
    assert (tmp_path / "page.md").read_text() == text
    with pytest.raises(InvalidInput, match="cannot read"):
        report.write(tmp_path / "none.md", {})


def test_stored_measurements_are_read_again(tmp_path: Path) -> None:
    file = tmp_path / "measured.json"
    assert report.read(file) == {}
    report.keep(file, {"lengths": [LENGTHS]})
    assert report.read(file) == {"lengths": [LENGTHS]}
    file.write_text("[1]")
    with pytest.raises(InvalidInput, match="is not a file of"):
        report.read(file)
    with pytest.raises(InvalidInput, match="cannot write"):
        report.keep(tmp_path / "none" / "measured.json", {})


def test_speed_ups_are_shown_with_their_targets() -> None:
    measurement = {
        "grid": "random 20 % 4096²", "reached": 1000, "seconds": {"1": 2e-6, "2": 1e-6},
        "ns_per_cell": {"1": 2.0, "2": 1.0}, "again_seconds": {"1": 2e-6, "2": 1e-6},
        "beside": {"navfn": 2e-5}, "left_out": {"tcod": "not installed"},
    }  # fmt: skip
    text = report.render({"fields": [measurement]})
    assert "| random 20 % 4096² | 1 | 10 |  | 7.2 × navfn, 33 × tcod | 20 |  |" in text
    assert "| random 20 % 4096² | 2 | 20 |  | 13 × navfn, 60 × tcod | 20 |  |" in text
    assert "- tcod on random 20 % 4096²: not installed" in text


@pytest.mark.parametrize(("load", "warned"), [(0.2, False), (1.5, True)])
def test_measurements_on_a_busy_machine_are_marked(load: float, warned: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suite.os, "getloadavg", lambda: (load, 0.0, 0.0))
    text = report.render({"machine": [suite.describe() | {"quick": False}]})
    assert text.startswith("Measured on ") and ("not suitable for comparison" in text) == warned


def test_the_spread_is_the_ratio_of_times_of_large_grids() -> None:
    with Progress(disable=True) as progress:
        result = scaling.measure(["empty"], [64, 512, 600], [1], progress)
    _, first, second = result["ns_per_cell"]["empty"]["1"]
    assert result["spread"]["empty"]["1"] == max(first, second) / min(first, second)
