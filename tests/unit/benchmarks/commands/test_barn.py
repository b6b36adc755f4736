"""``ppaas bench barn``."""

import json
from pathlib import Path

import pytest

from robots.cli.main import main
from tests.support.world import barn

KEYS = ["worlds", "runs", "success", "collision", "timeout", "metric", "at_over_ot", "min_clearance"]


def test_the_summary_of_all_runs_is_returned_with_a_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = barn.write(tmp_path / "worlds.json", barn.world(3), barn.world(9))
    picture = tmp_path / "run.png"
    command = ["bench", "barn", str(path), "--runs", "1", "--worlds", "9", "--jobs", "1", "--noise", "none"]
    assert main([*command, "--json", "--picture", str(picture)]) == 0
    result = json.loads(capsys.readouterr().out)
    assert list(result) == KEYS
    assert (result["worlds"], result["runs"], result["success"], result["metric"]) == (1, 1, 1.0, 0.5)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert main([*command, "--radius", "0.1"]) == 0
    table = capsys.readouterr().out
    assert "least clearance m" in table
    assert "world 9" in table


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        (["--planner", "hands"], "unknown controller 'hands'"),
        (["--worlds", "4"], "unknown world '4'"),
        (["--picture", "run.jpg"], "PNG"),
    ],
)
def test_unknown_and_invalid_options_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], wrong: list[str], error: str
) -> None:
    path = barn.write(tmp_path / "worlds.json", barn.world(3))
    assert main(["bench", "barn", str(path), "--runs", "1", "--jobs", "1", *wrong]) == 1
    assert error in capsys.readouterr().err
