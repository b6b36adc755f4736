"""``ppaas bench goals``."""

import json

import pytest

from benchmarks.navigation.goals import run
from robots.cli.main import main

RUN = ["bench", "goals", "--goals", "1", "--people", "1", "--jobs", "1", "--seed", "3"]


@pytest.fixture(autouse=True)
def short_goal_timeouts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the time limit of each goal to some seconds."""
    monkeypatch.setattr(run, "PATIENCE", 2.0)
    monkeypatch.setattr(run, "SLOWEST", 10.0)


def test_the_summary_is_returned_per_map_and_in_total(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*RUN, "--json", "--set", "amcl.max_particles=600"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["people"], result["planner"], result["goals"], list(result["maps"])) == (1, "dwa", 1, ["office"])
    assert result["maps"]["office"]["reached"] == result["reached"]
    assert {"collisions", "caused", "touched_by_people", "mean_seconds", "recoveries", "failures"} <= set(result)
    assert result["failures"] == {"timeout": 1}
    assert main(RUN) == 0
    shown = capsys.readouterr().out
    assert "office" in shown and "caused" in shown


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        (["--planner", "hands"], "hands"),
        (["--set", "amcl.max_beams=3"], "max_beams"),
        (["--set", "max_beams"], "NODE.NAME=VALUE"),
        (["--map", "nowhere.yaml"], "nowhere.yaml"),
        (["--drive", "1"], "--drive must be below 1"),
        (["--plot", "out.pdf"], "PNG"),
    ],
)
def test_unknown_and_invalid_options_are_refused(
    capsys: pytest.CaptureFixture[str], wrong: list[str], error: str
) -> None:
    assert main([*RUN, *wrong]) == 1
    assert error in capsys.readouterr().err
