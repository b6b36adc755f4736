"""``ppaas bench people``."""

import argparse

import pytest

from benchmarks.people import command, suite
from benchmarks.people.runs.job import DETECTIONS, POLICIES
from robots.cli.main import main


def options(*words: str) -> list[tuple[str, str, int, int, int]]:
    """Return the runs that arguments ask for: map, policy, robots, people, seed."""
    parser = argparse.ArgumentParser()
    command.configure(parser)
    jobs = command.options_of(parser.parse_args(words)).jobs
    return [(job.map, job.policy, job.robots, job.people, job.seed) for job in jobs]


def test_the_whole_table_is_the_default() -> None:
    assert len(options()) == 2 * 3 * 3 * 3 * 5


def test_a_part_of_the_table_is_chosen_by_options() -> None:
    chosen = options("--maps", "office", "--policies", "paper", "--robots", "2", "5", "--people", "1", "--seeds", "2")
    assert chosen == [("office", "paper", robots, 1, seed) for robots in (2, 5) for seed in (0, 1)]


def test_the_choices_of_the_command_are_those_of_the_parts() -> None:
    assert (command.PARTS, command.POLICIES, command.DETECTIONS) == (suite.NAMES, POLICIES, DETECTIONS)


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        (["--size", "big"], "WIDTHxHEIGHT"),
        (["--maps", "nowhere.yaml"], "nowhere.yaml"),
        (["--picture", "out.pdf"], "PNG"),
    ],
)
def test_invalid_options_are_refused(capsys: pytest.CaptureFixture[str], wrong: list[str], error: str) -> None:
    assert main(["bench", "people", "--only", "coordination", *wrong]) != 0
    assert error in capsys.readouterr().err
