"""Stand-ins of robots in ``ppaas bench fleet``: contacts, messages, faults and figures."""

from pathlib import Path
from random import Random

import numpy as np
import pytest
from rich.progress import Progress

from benchmarks.fleet import command
from benchmarks.fleet.stand_ins import hall, measure, strips
from benchmarks.fleet.stand_ins.simulation import Contacts, LossyNetwork, Simulation, roadmap_of
from benchmarks.fleet.stand_ins.strips import CASES
from ppaas.errors import InvalidInput
from robots.cli.command_parser import CommandParser

RADII = np.array([0.2, 0.2])


def driving(seconds: float) -> Simulation:
    """Return four robots in a room that have driven for a time [s]."""
    simulation = Simulation(roadmap_of("........\n" * 4), 1)
    for cell in (0, 7, 16, 23):
        simulation.add(cell)
    simulation.run(seconds, again=True)
    return simulation


def test_discs_that_pass_through_each_other_between_two_times_touch_once() -> None:
    contacts = Contacts()
    contacts.see(np.array([[0.0, 0.0], [1.0, 0.0]]), RADII)
    assert (contacts.count, contacts.nearest) == (0, pytest.approx(0.6))
    contacts.see(np.array([[1.0, 0.1], [0.0, 0.0]]), RADII)
    assert contacts.count == 1
    assert contacts.nearest < -0.3
    contacts.see(np.array([[1.0, 0.1], [1.0, 0.0]]), RADII)
    assert contacts.count == 2, "the discs were apart, and touch again"


def test_messages_are_late_and_lost_as_told() -> None:
    network = LossyNetwork(Random(1), delay=2.0, loss=0.1)
    for number in range(1000):
        network.send(number, 0.0)
    early, late = network.arrived(1.0), network.arrived(2.0)
    assert len(early) + len(late) == pytest.approx(900, abs=30)
    assert len(early) == pytest.approx(len(late), abs=90)
    assert early != sorted(early, key=str)


def test_a_stand_in_without_news_reports_twice_a_second() -> None:
    simulation = Simulation(roadmap_of("..."), 1)
    robot = simulation.add(0)
    reports = [robot.due_report(0.1 * cycle) for cycle in range(21)]
    assert sum(report is not None for report in reports) == 5


def test_robots_that_do_not_get_on_for_a_minute_are_in_a_deadlock() -> None:
    simulation = driving(10.0)
    simulation.kill_node()
    simulation.run(100.0, again=True)
    assert simulation.deadlocks == 1
    assert simulation.stood > 90.0


def test_a_robot_that_is_pushed_off_its_way_is_led_back() -> None:
    simulation = driving(10.0)
    assert 0.0 < measure.push_one(simulation) < 20.0
    assert simulation.contacts.count == 0


def test_the_next_node_grants_within_two_seconds() -> None:
    assert measure.restart_node(driving(10.0)) <= measure.GRANTS_AGAIN


def test_all_figures_of_stand_ins_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hall, "ALONE_SECONDS", 120.0)
    monkeypatch.setattr(measure, "WARM_UP", 10.0)
    parser = CommandParser()
    command.configure(parser)
    with Progress(disable=True) as progress:
        figures = command.measure(parser.parse_args(["--stand-ins", "office", "8", "1", "2"]), progress).result[
            "figures"
        ]
    told = {figure["name"].rpartition("seed 2")[2]: figure for figure in figures}
    assert told[": contacts"]["value"] == 0
    assert told[", messages up to 2 s late and 10% lost: contacts"]["value"] == 0
    assert told[": goals"]["value"] > 0
    assert told[": the next traffic node grants"]["value"] <= 2.0
    assert len(told) == 12


@pytest.mark.parametrize(
    "words",
    [
        ["garage", "2", "1", "1"],
        ["office", "two", "1", "1"],
        ["office", "99999", "1", "1"],
        ["office", "2", "0", "1"],
        ["office", "2", "1", "x"],
    ],
)
def test_a_wrong_case_of_stand_ins_is_refused(words: list[str]) -> None:
    with pytest.raises(InvalidInput):
        measure.case_of(words)


def test_pictures_of_the_reported_cases_are_drawn(tmp_path: Path) -> None:
    parser = CommandParser()
    command.configure(parser)
    with Progress(disable=True) as progress:
        measured = command.measure(parser.parse_args(["--pictures", str(tmp_path)]), progress)
    assert Path(measured.result["picture"]).read_bytes().startswith(b"\x89PNG")


def test_moments_of_a_case_lead_from_the_begin_to_the_goals() -> None:
    moments = strips.moments_of(CASES[0])
    assert len(moments) == strips.MOMENTS
    assert all(robot.held for moment in moments for robot in moment.robots)
    assert [robot.goal is None for robot in moments[0].robots] == [False, False]
    assert [robot.goal is None for robot in moments[-1].robots] == [True, True]


def test_pictures_need_a_folder(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="no folder"):
        strips.write_strips(tmp_path / "none")
