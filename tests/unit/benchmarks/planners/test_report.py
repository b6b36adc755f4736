"""A report replaces the part of a page between its marks, and nothing else."""

from pathlib import Path

import pytest

from benchmarks.planners import report
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
