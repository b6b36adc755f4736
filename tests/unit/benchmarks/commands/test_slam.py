"""``ppaas bench slam``."""

import argparse
from pathlib import Path
from typing import Any

import pytest

from benchmarks.commands import slam
from benchmarks.harness.figures import Figure, PartResult
from benchmarks.mapping.parts import suite
from benchmarks.mapping.parts.part import SlamOptions

FOUND = PartResult([Figure("logs", "a: mean", 0.5, "m", limit=0.1)], [{"log": "a", "scans": "7"}], [{"log": "a"}])


def parsed(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    slam.configure(parser)
    return parser.parse_args(list(words))


def test_the_parts_of_the_command_are_those_of_the_suite() -> None:
    assert slam.PARTS == suite.NAMES


def test_options_reach_the_parts() -> None:
    options = slam.options_of(parsed("a.clf", "--data", "d", "--no-worlds", "--graphs", "g.g2o", "--all-pairs"))
    assert options == SlamOptions(
        (Path("a.clf"),), Path("d"), worlds=False, graphs=(Path("g.g2o"),), all_pairs=True
    )  # fmt: skip
    assert slam.options_of(parsed()) == SlamOptions()


def test_figures_are_shown_with_their_bars_above_the_details(monkeypatch: pytest.MonkeyPatch) -> None:
    chosen: list[Any] = []
    monkeypatch.setattr(suite, "measure", lambda _options, only, _progress: chosen.append(only) or {"logs": FOUND})
    measured = slam.measure(parsed("--only", "logs"), None)  # type: ignore[arg-type]
    assert chosen == [["logs"]]
    assert measured.result["logs"] == [{"log": "a"}]
    assert measured.result["figures"][0]["name"] == "a: mean"
    figures, details = measured.text.split("\n\n")
    assert "≤ 0.1" in figures and "NO" in figures
    assert details.splitlines() == ["log  scans", "a    7"]
