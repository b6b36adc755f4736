"""A small map, and the JSON output of a bench."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from robots.cli.main import main

RunBench = Callable[..., dict[str, Any]]

MAP = "type octile\nheight 2\nwidth 3\nmap\n...\n.@.\n"
SCENARIO = "version 1\n0\ta.map\t3\t2\t0\t0\t2\t0\t2\n"


@pytest.fixture
def map_(tmp_path: Path) -> Path:
    """Return a map with a scenario beside it."""
    (tmp_path / "a.map.scen").write_text(SCENARIO)
    (tmp_path / "a.map").write_text(MAP)
    return tmp_path / "a.map"


@pytest.fixture
def run_bench(capsys: pytest.CaptureFixture[str]) -> RunBench:
    """Return a call that runs a bench and returns its JSON."""

    def run(*arguments: str) -> dict[str, Any]:
        assert main(["bench", *arguments, "--json"]) == 0
        answer: dict[str, Any] = json.loads(capsys.readouterr().out)
        return answer

    return run
