"""What performance.md tells of planners is what was measured, and its commands are those there are."""

import re

from benchmarks.commands import planners
from benchmarks.planners import report
from robots.cli.main import EXTRAS
from tests.support.documents import text_of
from tests.support.sources import ROOT

PAGE = "docs/performance.md"


def test_the_part_of_the_planners_is_what_was_measured() -> None:
    part = text_of(PAGE).partition(report.BEGIN)[2].partition(report.END)[0]
    assert part.strip() == report.render(report.read(ROOT / "docs" / "performance.json"))


def test_the_commands_are_those_there_are() -> None:
    named = set(re.findall(r"^\| `ppaas bench (\w+)", text_of(PAGE), re.MULTILINE))
    assert named == set(planners.HELP)
    assert EXTRAS["scipy"] == "bench" and "pip install 'ppaas[bench]'" in text_of(PAGE)
