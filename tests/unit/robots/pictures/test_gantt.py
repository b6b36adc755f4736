"""Gantt charts of time tables."""

from pathlib import Path

import pytest

from ppaas.errors import InvalidInput
from ppaas.tasks.timetable import TimeTableRow
from robots.pictures.gantt import DONE, LATE, draw_gantt, write_gantt

ROWS = [
    TimeTableRow("a", "r1", 0.0, 5.0, 20.0, 0.0, "done", False, ""),
    TimeTableRow("b", "r2", 0.0, 8.0, 30.0, 0.0, "done", True, "", "L1 → L2"),
    TimeTableRow("c", "r1", 20.0, None, None, 20.0, "assigned", False, ""),
    TimeTableRow("d", "", None, None, None, None, "queued", False, ""),
]


def test_each_robot_has_a_line_with_its_ways_and_tasks() -> None:
    from matplotlib.colors import to_rgba

    [axes] = draw_gantt("morning", ROWS).axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["r1", "r2"]
    bars = [(bar.get_x(), bar.get_width(), bar.get_facecolor()) for bar in axes.patches]
    assert (5.0, 15.0, to_rgba(DONE)) in bars
    assert (8.0, 22.0, to_rgba(LATE)) in bars
    assert len(bars) == 6
    assert [text.get_text() for text in axes.texts] == ["a", "b\nL1 → L2", "c"]


def test_a_chart_is_a_png_file_and_one_of_nothing_is_refused(tmp_path: Path) -> None:
    write_gantt(tmp_path / "chart.png", "morning", ROWS)
    assert (tmp_path / "chart.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(InvalidInput, match="nothing to draw"):
        write_gantt(tmp_path / "chart.png", "morning", ROWS[3:])
