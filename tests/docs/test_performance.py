"""The figures of performance.md are those that were measured, and every bench is on a page."""

import re
import tomllib

from benchmarks.planners import report
from robots.cli.benches import GROUP
from robots.cli.main import EXTRAS
from tests.support.documents import text_of
from tests.support.sources import ROOT

PAGE = "docs/performance.md"
PAGES = [file.relative_to(ROOT).as_posix() for file in [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")]]


def test_the_part_of_the_planners_is_what_was_measured() -> None:
    part = text_of(PAGE).partition(report.BEGIN)[2].partition(report.END)[0]
    assert part.strip() == report.render(report.read(ROOT / "docs" / "performance.json"))


def test_every_bench_is_on_a_page() -> None:
    benches = tomllib.loads((ROOT / "benchmarks" / "pyproject.toml").read_text())["project"]["entry-points"][GROUP]
    named = {name for page in PAGES for name in re.findall(r"`ppaas bench ([a-z]\w*)", text_of(page))}
    assert named == set(benches)


def test_the_peers_come_with_the_extra_that_is_named() -> None:
    assert EXTRAS["scipy"] == "bench" and "pip install '.[bench]'" in text_of(PAGE)
