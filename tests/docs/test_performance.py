"""Figures of performance.md are the measured ones, and every bench is documented."""

import re
import tomllib

from benchmarks.planners import report
from robots.cli.benches import GROUP
from robots.cli.main import EXTRAS
from tests.support.documents import text_of
from tests.support.sources import ROOT

PAGE = "docs/performance.md"
PAGES = [file.relative_to(ROOT).as_posix() for file in [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")]]


def test_the_planner_figures_are_the_measured_ones() -> None:
    part = text_of(PAGE).partition(report.BEGIN)[2].partition(report.END)[0]
    assert part.strip() == report.render(report.read(ROOT / "docs" / "performance.json"))


def test_every_bench_is_documented() -> None:
    benches = tomllib.loads((ROOT / "benchmarks" / "pyproject.toml").read_text())["project"]["entry-points"][GROUP]
    named = {name for page in PAGES for name in re.findall(r"`ppaas bench ([a-z]\w*)", text_of(page))}
    assert named == set(benches)


def test_the_extra_of_the_compared_libraries_is_named() -> None:
    assert EXTRAS["scipy"] == "bench" and "pip install '.[bench]'" in text_of(PAGE)
