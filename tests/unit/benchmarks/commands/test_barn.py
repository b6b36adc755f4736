"""``ppaas bench barn``."""

import json
from pathlib import Path

import pytest

from robots.cli.main import main
from tests.support.world import barn

KEYS = ["worlds", "runs", "success", "collision", "timeout", "metric", "at_over_ot", "min_clearance"]


def test_it_tells_what_all_runs_come_to(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = barn.write(tmp_path / "worlds.json", barn.world(3), barn.world(9))
    picture = tmp_path / "run.png"
    asked = ["bench", "barn", str(path), "--runs", "1", "--worlds", "9", "--jobs", "1", "--noise", "none"]
    assert main([*asked, "--json", "--picture", str(picture)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert list(told) == KEYS
    assert (told["worlds"], told["runs"], told["success"], told["metric"]) == (1, 1, 1.0, 0.5)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert main([*asked, "--radius", "0.1"]) == 0
    table = capsys.readouterr().out
    assert "least clearance m" in table
    assert "world 9" in table


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (["--planner", "hands"], "unknown controller 'hands'"),
        (["--worlds", "4"], "unknown world '4'"),
        (["--picture", "run.jpg"], "PNG"),
    ],
)
def test_what_there_is_not_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], wrong: list[str], told: str
) -> None:
    path = barn.write(tmp_path / "worlds.json", barn.world(3))
    assert main(["bench", "barn", str(path), "--runs", "1", "--jobs", "1", *wrong]) == 1
    assert told in capsys.readouterr().err
