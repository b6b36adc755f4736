"""``ppaas bench`` for planners: what programs read of it, and what is refused."""

import json
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from benchmarks.planners import compare, peers
from robots.cli.main import main

MAP = "type octile\nheight 2\nwidth 3\nmap\n...\n.@.\n"
SCENARIO = "version 1\n0\ta.map\t3\t2\t0\t0\t2\t0\t2\n"


@pytest.fixture
def map_(tmp_path: Path) -> Path:
    """Return a map with a scenario beside it."""
    (tmp_path / "a.map.scen").write_text(SCENARIO)
    (tmp_path / "a.map").write_text(MAP)
    return tmp_path / "a.map"


def told(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert main(["bench", *arguments, "--json"]) == 0
    answer: dict[str, Any] = json.loads(capsys.readouterr().out)
    return answer


def test_the_json_of_a_scenario_has_these_keys(capsys: pytest.CaptureFixture[str], map_: Path) -> None:
    answer = told(capsys, "scenario", f"{map_}.scen", "--map", str(map_), "--planner", "dijkstra", "--limit", "1")
    assert set(answer) == {
        "planner", "queries", "wrong", "mean_us", "p50_us", "p99_us", "index_seconds", "index_bytes",
    }  # fmt: skip
    assert (answer["planner"], answer["queries"], answer["wrong"]) == ("dijkstra", 1, 0)


def test_the_map_of_a_scenario_is_looked_for_beside_it(capsys: pytest.CaptureFixture[str], map_: Path) -> None:
    assert told(capsys, "scenario", f"{map_}.scen")["wrong"] == 0


def test_the_json_of_an_index_has_seconds_by_threads(capsys: pytest.CaptureFixture[str], map_: Path) -> None:
    answer = told(capsys, "index", "--map", str(map_), "--tiles", "3", "--threads", "1,2")
    assert set(answer) == {
        "grid", "planner", "seconds", "bytes", "queries", "wrong", "mean_us", "p50_us", "p99_us", "cpus",
    }  # fmt: skip
    assert (answer["grid"], answer["planner"], answer["wrong"]) == ("3 by 3 times a", "hub_labels", 0)
    assert set(answer["seconds"]) == {"1", "2"}


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
def test_the_json_of_a_field_counts_its_cells(
    capsys: pytest.CaptureFixture[str], grid: list[str], cells: int, reached: int
) -> None:
    answer = told(capsys, "field", *grid, "--threads", "1,2")
    assert (answer["cells"], answer["reached"]) == (cells, reached)
    assert set(answer["seconds"]) == set(answer["ns_per_cell"]) == {"1", "2"}


def test_a_field_is_grown_from_the_goal_asked_for_on_any_map(capsys: pytest.CaptureFixture[str], map_: Path) -> None:
    answer = told(capsys, "field", "--map", str(map_), "--goal", "1", "2", "--threads", "1")
    assert (answer["goal"], answer["cells"], answer["reached"]) == ([1, 2], 6, 5)


def test_a_field_is_measured_beside_others(capsys: pytest.CaptureFixture[str], map_: Path) -> None:
    answer = told(capsys, "field", "--map", str(map_), "--threads", "1", "--beside", "navfn")
    assert answer["beside"]["navfn"] > 0.0
    assert main(["bench", "field", "--map", str(map_), "--threads", "1", "--beside", "navfn"]) == 0
    assert "× navfn" in capsys.readouterr().out.splitlines()[0]


def test_people_read_a_table(capsys: pytest.CaptureFixture[str], map_: Path) -> None:
    assert main(["bench", "scenario", f"{map_}.scen"]) == 0
    heading, row = (line.split("  ") for line in capsys.readouterr().out.splitlines())
    assert (heading[0].strip(), row[0].strip()) == ("planner", "dijkstra")


@pytest.mark.parametrize(
    ("arguments", "slug"),
    [
        (["field", "--map", "none.map"], "invalid-map"),
        (["field", "--empty", "0"], "invalid-parameter"),
        (["field", "--random", "2.5", "10"], "invalid-input"),
        (["field", "--random", "9", "100"], "invalid-parameter"),
        (["field", "--maze", "9", "1", "1"], "invalid-input"),
        (["field", "--empty", "9", "--tiles", "0"], "invalid-parameter"),
        (["index", "--empty", "9", "--planner", "dijkstra"], "invalid-parameter"),
        (["field", "--empty", "3", "--goal", "3", "0"], "goal-outside-map"),
        (["field", "--empty", "3", "--plot", "a.svg"], "invalid-input"),
        (["scenario", "none.scen"], "invalid-map"),
        (["field", "--empty", "3", "--beside", "ros"], "not-found"),
        (["compare", "--empty", "3", "--only", "ours"], "not-found"),
        (["scaling", "--largest", "255"], "invalid-parameter"),
        (["scaling", "--kind", "forest", "--largest", "256"], "not-found"),
        (["fig3", "--map", "none.yaml"], "invalid-map"),
    ],
)
def test_what_cannot_be_measured_is_refused(
    capsys: pytest.CaptureFixture[str], arguments: list[str], slug: str
) -> None:
    assert main(["bench", *arguments]) == 1
    assert capsys.readouterr().err.strip().startswith(f"ppaas: {slug}: ")


@pytest.mark.parametrize("threads", ["0", "x", "1,", "1,-2"])
def test_threads_are_whole_numbers(capsys: pytest.CaptureFixture[str], threads: str) -> None:
    with pytest.raises(SystemExit):
        main(["bench", "field", "--empty", "3", "--threads", threads])
    assert "whole numbers from 1 up" in capsys.readouterr().err


@pytest.mark.parametrize("pause", ["-1", "nan", "61", "soon"])
def test_a_pause_is_a_while(capsys: pytest.CaptureFixture[str], pause: str) -> None:
    with pytest.raises(SystemExit):
        main(["bench", "field", "--empty", "3", "--pause", pause])
    assert "a pause is 0 to 60 s long" in capsys.readouterr().err


def test_a_plot_of_a_field_is_the_time_over_the_length(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    told(capsys, "field", "--empty", "40", "--threads", "1", "--plot", str(tmp_path / "lengths.png"))
    with Image.open(tmp_path / "lengths.png") as picture:
        assert picture.format == "PNG"


def test_scaling_has_a_number_for_each_size(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    plot = tmp_path / "scaling.png"
    answer = told(capsys, "scaling", "--kind", "empty", "--largest", "600", "--threads", "1", "--plot", str(plot))
    assert answer["sizes"] == [256, 512]
    assert len(answer["ns_per_cell"]["empty"]["1"]) == 2
    assert plot.exists()


def test_a_comparison_names_who_is_missing_and_who_cannot(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    field, path = peers.FIELDS[2], peers.PATHS[0]
    absent = peers.Peer("f", "absent-peer", "absent_peer", "nothing", field.prepare, field.told)
    small = peers.Peer(field.name, field.package, field.module, field.solves, field.prepare, field.told, 9)
    monkeypatch.setattr(compare, "BESIDE", {"absent-peer": absent, "scipy": small})
    monkeypatch.setattr(compare, "PATHS", ())
    assert main(["bench", "compare", "--empty", "8", "--threads", "1"]) == 0
    out, err = capsys.readouterr()
    assert "absent-peer f is left out: not installed" in err
    assert "scipy csgraph.dijkstra is left out: the grid is too large" in err
    assert "ppaas dijkstra, 1 thread" in out and path.package not in out
