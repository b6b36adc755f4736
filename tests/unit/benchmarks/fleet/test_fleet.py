"""``ppaas bench fleet``: its cases and its figures."""

from pathlib import Path

import pytest
from rich.progress import Progress

from benchmarks.fleet import cases, command, traffic
from ppaas.errors import InvalidInput
from robots.cli.command_parser import CommandParser

MAP = "type octile\nheight 2\nwidth 4\nmap\n....\n....\n"
SCENARIO = "version 1\n0 m 4 2 0 0 3 0 3.0\n0 m 4 2 3 0 0 0 3.0\n"


def test_robots_of_halls_that_are_made_up_have_ways() -> None:
    for case in cases.MADE:
        problem = case.read()
        assert len(problem) == case.robots
        assert problem.bound > 5 * case.robots


def test_all_figures_of_a_case_are_told_and_no_plan_has_a_fault(tmp_path: Path) -> None:
    (tmp_path / "m.map").write_text(MAP)
    (tmp_path / "m.scen").write_text(SCENARIO)
    parser = CommandParser()
    command.configure(parser)
    words = ["--quick", "--case", str(tmp_path / "m.map"), str(tmp_path / "m.scen"), "2"]
    with Progress(disable=True) as progress:
        figures = command.measure(parser.parse_args(words), progress).result["figures"]
    told = {figure["name"]: figure["value"] for figure in figures}
    assert told["m, 2: cost after 0.2 s"] == pytest.approx(8 / 6, abs=0.2)
    assert told["m, 2: faults"] == 0
    assert 0 < told["m, 2: goals"] <= 2
    assert told["m, 2: 0.2 s with turns: mean arrival"] >= 4
    assert len(told) == 12


@pytest.mark.parametrize("robots", ["0", "many", "-1"])
def test_a_number_of_robots_that_is_none_is_refused(robots: str) -> None:
    with pytest.raises(InvalidInput, match="at least 1"):
        cases.case_of(["m.map", "m.scen", robots])


def test_robots_in_traffic_are_measured_beside_one_that_is_alone() -> None:
    figures = {
        figure.name.rpartition(": ")[2]: figure for figure in traffic.measure(traffic.TrafficCase("office", 2, 8.0))
    }
    assert figures["contacts of robots"].value == 0
    assert "of 2 robots that are each alone" in figures["goals"].note


@pytest.mark.parametrize("words", [["garage", "2", "1", "1"], ["office", "two", "1", "1"]])
def test_a_wrong_case_of_traffic_is_refused(words: list[str]) -> None:
    with pytest.raises(InvalidInput):
        traffic.case_of(words)
