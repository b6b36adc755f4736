"""``ppaas bench field``: JSON, table, and errors."""

from pathlib import Path

import pytest
from PIL import Image

from robots.cli.main import main
from tests.unit.benchmarks.commands.conftest import Told


@pytest.mark.parametrize(
    ("grid", "cells", "reached"),
    [
        (["--empty", "16"], 256, 256),
        (["--maze", "9"], 81, 16 + 15),
        (["--maze", "9", "3"], 81, 4 * 9 + 3 * 3),
        (["--random", "8", "0"], 64, 64),
        (["--random", "8", "0", "--tiles", "2"], 256, 256),
    ],
)
def test_the_json_of_a_field_counts_its_cells(grid: list[str], cells: int, reached: int, told: Told) -> None:
    answer = told("field", *grid, "--threads", "1,2")
    assert (answer["cells"], answer["reached"]) == (cells, reached)
    assert set(answer["seconds"]) == set(answer["ns_per_cell"]) == {"1", "2"}


def test_a_field_is_grown_from_the_goal_asked_for_on_any_map(map_: Path, told: Told) -> None:
    answer = told("field", "--map", str(map_), "--goal", "1", "2", "--threads", "1")
    assert (answer["goal"], answer["cells"], answer["reached"]) == ([1, 2], 6, 5)


def test_a_field_is_measured_beside_others(capsys: pytest.CaptureFixture[str], map_: Path, told: Told) -> None:
    answer = told("field", "--map", str(map_), "--threads", "1", "--beside", "navfn")
    assert answer["beside"]["navfn"] > 0.0
    assert main(["bench", "field", "--map", str(map_), "--threads", "1", "--beside", "navfn"]) == 0
    assert "× navfn" in capsys.readouterr().out.splitlines()[0]


def test_a_plot_of_a_field_is_the_time_over_the_length(tmp_path: Path, told: Told) -> None:
    told("field", "--empty", "40", "--threads", "1", "--plot", str(tmp_path / "lengths.png"))
    with Image.open(tmp_path / "lengths.png") as picture:
        assert picture.format == "PNG"


@pytest.mark.parametrize("threads", ["0", "x", "1,", "1,-2"])
def test_threads_are_whole_numbers(capsys: pytest.CaptureFixture[str], threads: str) -> None:
    with pytest.raises(SystemExit):
        main(["bench", "field", "--empty", "3", "--threads", threads])
    assert "whole numbers from 1 up" in capsys.readouterr().err


@pytest.mark.parametrize("pause", ["-1", "nan", "61", "soon"])
def test_a_pause_is_a_while(capsys: pytest.CaptureFixture[str], pause: str) -> None:
    with pytest.raises(SystemExit):
        main(["bench", "field", "--empty", "3", "--pause", pause])
    assert "--pause must be 0 to 60 seconds" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "slug"),
    [
        (["field", "--map", "none.map"], "invalid-map"),
        (["field", "--empty", "0"], "invalid-parameter"),
        (["field", "--random", "2.5", "10"], "invalid-input"),
        (["field", "--random", "9", "100"], "invalid-parameter"),
        (["field", "--maze", "9", "1", "1"], "invalid-input"),
        (["field", "--empty", "9", "--tiles", "0"], "invalid-parameter"),
        (["field", "--empty", "3", "--goal", "3", "0"], "goal-outside-map"),
        (["field", "--empty", "3", "--plot", "a.svg"], "invalid-input"),
        (["field", "--empty", "3", "--beside", "ros"], "not-found"),
    ],
)
def test_what_cannot_be_measured_is_refused(
    capsys: pytest.CaptureFixture[str], arguments: list[str], slug: str
) -> None:
    assert main(["bench", *arguments]) == 1
    assert capsys.readouterr().err.strip().startswith(f"ppaas: {slug}: ")
