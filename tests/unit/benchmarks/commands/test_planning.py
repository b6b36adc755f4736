"""``ppaas bench planning``."""

import json

import pytest

from robots.cli.main import main


def test_planning_is_measured_without_a_cloud(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "planning", "--quick", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)["figures"]
    assert {figure["name"] for figure in figures} >= {
        "empty 256², layers", "empty 256², dijkstra",
        "pillars 256², exact inflation 0.55 m, threads 1", "depth image 640×480 uint16 → scan, 10 rows",
    }  # fmt: skip
    assert all(figure["value"] > 0.0 for figure in figures)
