"""``ppaas bench field``: JSON, table, and errors."""

from pathlib import Path

import pytest
from PIL import Image

from robots.cli.main import main
from tests.unit.benchmarks.commands.conftest import RunBench


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
def test_the_json_of_a_field_counts_its_cells(grid: list[str], cells: int, reached: int, run_bench: RunBench) -> None:
    answer = run_bench("field", *grid, "--threads", "1,2")
    assert (answer["cells"], answer["reached"]) == (cells, reached)
    assert set(answer["seconds"]) == set(answer["ns_per_cell"]) == {"1", "2"}


def test_a_field_is_computed_from_the_given_goal_of_any_map(map_: Path, run_bench: RunBench) -> None:
    answer = run_bench("field", "--map", str(map_), "--goal", "1", "2", "--threads", "1")
    assert (answer["goal"], answer["cells"], answer["reached"]) == ([1, 2], 6, 5)


def test_a_field_is_compared_with_other_planners(
    capsys: pytest.CaptureFixture[str], map_: Path, run_bench: RunBench
) -> None:
    answer = run_bench("field", "--map", str(map_), "--threads", "1", "--beside", "navfn")
    assert answer["beside"]["navfn"] > 0.0
    assert main(["bench", "field", "--map", str(map_), "--threads", "1", "--beside", "navfn"]) == 0
    assert "× navfn" in capsys.readouterr().out.splitlines()[0]


def test_a_plot_shows_time_over_path_length(tmp_path: Path, run_bench: RunBench) -> None:
    run_bench("field", "--empty", "40", "--threads", "1", "--plot", str(tmp_path / "lengths.png"))
    with Image.open(tmp_path / "lengths.png") as picture:
        assert picture.format == "PNG"


@pytest.mark.parametrize("threads", ["0", "x", "1,", "1,-2"])
def test_invalid_numbers_of_threads_are_refused(capsys: pytest.CaptureFixture[str], threads: str) -> None:
    with pytest.raises(SystemExit):
        main(["bench", "field", "--empty", "3", "--threads", threads])
    assert "whole numbers from 1 up" in capsys.readouterr().err


@pytest.mark.parametrize("pause", ["-1", "nan", "61", "soon"])
def test_an_invalid_pause_is_refused(capsys: pytest.CaptureFixture[str], pause: str) -> None:
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
def test_invalid_maps_goals_and_options_are_refused(
    capsys: pytest.CaptureFixture[str], arguments: list[str], slug: str
) -> None:
    assert main(["bench", *arguments]) == 1
    assert capsys.readouterr().err.strip().startswith(f"ppaas: {slug}: ")
