"""``ppaas fleet plan``: plans for the agents of MovingAI's scenarios."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.fleet.checking import faults_of
from ppaas.errors import InvalidInput, NoValidPath
from ppaas.fleet.improvement import MOST_TURN
from ppaas.fleet.plan import FleetPlan
from ppaas.fleet.roadmap import Roadmap
from robots.cli.command_parser import CommandParser
from robots.cli.commands import fleet
from tests.support.sources import ROOT

MAP = """type octile
height 3
width 6
map
......
.@@@@.
......
"""
EXAMPLES = ROOT / "docs" / "examples"
AGENTS = ((0, 0, 5, 2), (5, 0, 0, 2), (0, 2, 5, 0), (3, 2, 3, 0))
"""Columns and rows of starts and goals."""


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    (tmp_path / "ring.map").write_text(MAP)
    lines = ["\t".join(map(str, (0, "ring.map", 6, 3, *agent, 1.0))) for agent in AGENTS]
    (tmp_path / "ring.scen").write_text("\n".join(["version 1", *lines]) + "\n")
    return tmp_path / "ring.map", tmp_path / "ring.scen"


def run(files: tuple[Path, Path], *words: object) -> int:
    parser = CommandParser()
    fleet.configure(parser)
    return fleet.run(parser.parse_args(["plan", str(files[0]), "--scen", str(files[1]), *map(str, words)]))


def planned(capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def roadmap() -> Roadmap:
    rows = MAP.splitlines()[4:]
    return Roadmap.of_grid(np.array([[mark == "." for mark in row] for row in rows]))


@pytest.mark.parametrize("options", [(), ("--seconds", 0.3), ("--seconds", 0.3, "--threads", 2, "--seed", 5)])
def test_the_printed_paths_are_a_plan_of_the_printed_cost(
    files: tuple[Path, Path], capsys: pytest.CaptureFixture[str], options: tuple[object, ...]
) -> None:
    assert run(files, "--json", *options) == 0
    answer = planned(capsys)
    cells = roadmap()
    steps = np.array([cells.at(np.array(path), "cell") for path in answer["paths"]]).T
    plan = FleetPlan(steps, answer["bound"])
    starts, goals = [cells.at(np.array([agent[k : k + 2][::-1] for agent in AGENTS]), "cell").tolist() for k in (0, 2)]
    assert faults_of(cells, plan, starts, goals) == []
    assert (answer["agents"], answer["cost"], answer["makespan"]) == (4, plan.cost, plan.makespan)
    assert answer["bound"] <= answer["cost"] <= answer["first"]["cost"]
    assert answer["first"]["cpu_seconds"] <= answer["cpu_seconds"]


def test_turns_are_told_where_they_cost_something(files: tuple[Path, Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(files, "--json", "--agents", 1) == 0
    plain = planned(capsys)
    assert run(files, "--json", "--agents", 1, "--turn", 1.5, "--seconds", 0.3) == 0
    turning = planned(capsys)
    assert set(turning) - set(plain) == {"turns"}
    assert (turning["turns"], turning["cost"]) == (1, 7)


def test_the_dearest_turn_is_that_of_the_improvement() -> None:
    assert fleet.MOST_TURN == MOST_TURN


def test_the_first_agents_are_planned_and_shown_as_a_table(
    files: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(files, "--agents", 1) == 0
    heading, row = capsys.readouterr().out.splitlines()
    assert heading.split() == list(fleet.COLUMNS)
    assert row.split()[:4] == ["1", "7", "7", "7"]


@pytest.mark.parametrize(
    "words", [("--agents", 0), ("--seconds", "nan"), ("--threads", 0), ("--seed", -1), ("--turn", 0)]
)
def test_options_that_are_impossible(files: tuple[Path, Path], words: tuple[object, ...]) -> None:
    with pytest.raises(SystemExit):
        run(files, *words)


def test_a_scenario_with_fewer_agents_is_an_error(files: tuple[Path, Path]) -> None:
    with pytest.raises(InvalidInput, match="has 4 agents, not 5"):
        run(files, "--agents", 5)


def test_a_file_that_cannot_be_read_is_named(files: tuple[Path, Path], tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="no-map"):
        run((tmp_path / "no-map", files[1]))
    with pytest.raises(InvalidInput, match="not a MovingAI scenario"):
        run((files[0], files[0]))


def test_agents_without_a_plan_are_an_error(files: tuple[Path, Path]) -> None:
    files[0].write_text("type octile\nheight 1\nwidth 3\nmap\n...\n")
    lines = ["0 m 3 1 0 0 2 0 1.0", "0 m 3 1 2 0 0 0 1.0"]
    files[1].write_text("\n".join(["version 1", *lines]))
    with pytest.raises(NoValidPath, match="cannot pass each other"):
        run(files)


LANES = EXAMPLES / "office.lanes.geojson"


def check(*words: object) -> int:
    parser = CommandParser()
    fleet.configure(parser)
    return fleet.run(parser.parse_args(["lanes", str(EXAMPLES / "office.yaml"), *map(str, words)]))


def test_lanes_are_told_and_drawn(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    picture = tmp_path / "lanes.png"
    assert check("--zones", LANES, "--radius", 0.18, "--picture", picture, "--json") == 0
    assert planned(capsys) == {"cells": 57, "width": 0.56, "length": 40.6, "longest_move": 1.0}
    assert picture.stat().st_size > 1000


@pytest.mark.parametrize(
    ("zones", "radius", "message"),
    [
        (LANES, 0.35, "lane 'copy room' is too short between 1.00, 4.60 and 1.00, 5.40"),
        (EXAMPLES / "office.zones.geojson", 0.18, "office.zones.geojson has no zones of the kind 'lane'"),
        (EXAMPLES / "none.geojson", 0.18, "cannot read"),
        (EXAMPLES / "office.yaml", 0.18, "zones are not valid JSON"),
    ],
)
def test_lanes_without_room_and_files_that_are_none_are_told(zones: Path, radius: float, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        check("--zones", zones, "--radius", radius)
