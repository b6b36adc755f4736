"""``ppaas bench control``."""

import json
from pathlib import Path

import pytest

from robots.cli.main import main


def test_it_tells_how_long_cycles_take(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "cycles.png"
    asked = ["bench", "control", "--planner", "pure_pursuit", "--goals", "1"]
    assert main([*asked, "--json", "--plot", str(picture)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["map"], told["window"], told["rate"], told["threads"]) == ("office", 120, 20.0, 1)
    [row] = told["planners"]
    assert 0.0 < row["median_ms"] <= row["p99_ms"] <= row["longest_ms"]
    assert (row["planner"], row["arrived"], row["goals"]) == ("pure_pursuit", 1, 1)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert main(asked) == 0
    assert "p99_ms ≤ 10" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("wrong", "told"), [(["--planner", "hands"], "unknown controller 'hands'"), (["--plot", "cycles.jpg"], "PNG")]
)
def test_what_there_is_not_is_refused(capsys: pytest.CaptureFixture[str], wrong: list[str], told: str) -> None:
    assert main(["bench", "control", *wrong]) != 0
    assert told in capsys.readouterr().err
