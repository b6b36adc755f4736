"""``ppaas bench control``."""

import json
from pathlib import Path

import pytest

from robots.cli.main import main


def test_cycle_times_are_measured_and_plotted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "cycles.png"
    command = ["bench", "control", "--planner", "pure_pursuit", "--goals", "1"]
    assert main([*command, "--json", "--plot", str(picture)]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["map"], result["window"], result["rate"], result["threads"]) == ("office", 120, 20.0, 1)
    [row] = result["planners"]
    assert 0.0 < row["median_ms"] <= row["p99_ms"] <= row["longest_ms"]
    assert (row["planner"], row["arrived"], row["goals"]) == ("pure_pursuit", 1, 1)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert main(command) == 0
    assert "p99_ms ≤ 10" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("wrong", "error"), [(["--planner", "hands"], "unknown controller 'hands'"), (["--plot", "cycles.jpg"], "PNG")]
)
def test_unknown_planners_and_invalid_plots_are_refused(
    capsys: pytest.CaptureFixture[str], wrong: list[str], error: str
) -> None:
    assert main(["bench", "control", *wrong]) != 0
    assert error in capsys.readouterr().err
