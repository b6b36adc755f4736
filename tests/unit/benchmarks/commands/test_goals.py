"""``ppaas bench goals``."""

import json

import pytest

from benchmarks.navigation.goals import run
from robots.cli.main import main

RUN = ["bench", "goals", "--goals", "1", "--people", "1", "--jobs", "1", "--seed", "3"]


@pytest.fixture(autouse=True)
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give each goal up after some seconds."""
    monkeypatch.setattr(run, "PATIENCE", 2.0)
    monkeypatch.setattr(run, "SLOWEST", 10.0)


def test_it_tells_what_goals_come_to_in_each_map_and_together(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*RUN, "--json", "--set", "amcl.max_particles=600"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["people"], told["planner"], told["goals"], list(told["maps"])) == (1, "dwa", 1, ["office"])
    assert told["maps"]["office"]["reached"] == told["reached"]
    assert {"collisions", "caused", "touched_by_people", "mean_seconds", "recoveries", "failures"} <= set(told)
    assert told["failures"] == {"timeout": 1}
    assert main(RUN) == 0
    shown = capsys.readouterr().out
    assert "office" in shown and "caused" in shown


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (["--planner", "hands"], "hands"),
        (["--set", "amcl.max_beams=3"], "max_beams"),
        (["--set", "max_beams"], "NODE.NAME=VALUE"),
        (["--map", "nowhere.yaml"], "nowhere.yaml"),
        (["--drive", "1"], "--drive must be below 1"),
        (["--plot", "out.pdf"], "PNG"),
    ],
)
def test_what_there_is_not_is_refused(capsys: pytest.CaptureFixture[str], wrong: list[str], told: str) -> None:
    assert main([*RUN, *wrong]) == 1
    assert told in capsys.readouterr().err
