"""``ppaas bench``, its parts that need no cloud."""

import json

import pytest

from benchmarks.service import suite
from robots.cli.commands import bench
from robots.cli.main import main


def test_planning_is_measured_without_a_cloud(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "planning", "--quick", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)["figures"]
    assert {figure["name"] for figure in figures} >= {
        "empty 256², layers", "empty 256², dijkstra",
        "pillars 256², exact inflation 0.55 m, threads 1", "depth image 640×480 uint16 → scan, 10 rows",
    }  # fmt: skip
    assert all(figure["value"] > 0.0 for figure in figures)


def test_a_running_cloud_wants_a_token(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.delenv("PPAAS_TOKEN", raising=False)
    assert main(["bench", "service", "--url", "http://127.0.0.1:1"]) == 1
    assert "not-authenticated" in capsys.readouterr().err


def test_a_part_that_there_is_not_is_refused_with_those_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["bench", "service", "--only", "weather"])
    assert "fleet" in capsys.readouterr().err


def test_every_part_that_can_be_named_is_measured() -> None:
    assert set(bench.PARTS) == {*suite.PARTS, suite.startup.PART}
