"""Figures of performance.md are the measured ones, and every bench is documented."""

import re
import tomllib

from benchmarks.commands.cloud import EngineBench
from benchmarks.engine import master, recovery
from benchmarks.engine.capacity import CORES
from benchmarks.engine.master import BALANCERS
from benchmarks.engine.options import PAUSES, READY_LIMIT_MS, EngineOptions
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


ENGINE_PAGE = "docs/engine.md"


def test_exactly_the_parts_and_options_of_the_bench_are_listed() -> None:
    named = re.findall(r"^\| `(\w+)` \|", text_of(ENGINE_PAGE).partition("## What is measured")[2], re.MULTILINE)
    assert sorted(named[: len(EngineBench.PARTS)]) == sorted(EngineBench.PARTS)
    options = re.findall(r"`(--[a-z]+)", text_of(ENGINE_PAGE).partition("## What is measured")[0])
    assert set(options) == {"--only", "--runtime", "--containers", "--placements", "--machines", "--quick", "--json"}


def test_the_limits_are_those_of_the_bench() -> None:
    text = " ".join(text_of(ENGINE_PAGE).split())
    assert ", ".join(f"{name} {limit:g} ms" for name, limit in READY_LIMIT_MS.items()) in text
    assert ", ".join(f"{name} {limit:g} ms" for name, limit in recovery.CRASH_LIMITS_MS.items()) in text
    assert f"| {recovery.LOSS_LIMIT_MS:g} ms |" in text
    assert f"| {master.RATE_LIMIT:g} a second |" in text
    default = EngineOptions()
    assert f"({default.containers})" in text and f"({default.placements} on {default.machines})" in text
    assert f"containers of {CORES:g} cores" in text
    assert PAUSES == {"docker": 5.0} and "five seconds apart" in text
    assert all(f"by `{balancer}`" in text for balancer in BALANCERS)
