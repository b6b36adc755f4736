"""Parts, options and limits in engine.md are those of the bench."""

import re

from benchmarks.commands.cloud import Engine
from benchmarks.engine import master, recovery
from benchmarks.engine.capacity import CORES
from benchmarks.engine.master import BALANCERS
from benchmarks.engine.options import PAUSES, READY_LIMIT_MS, EngineOptions
from tests.support.documents import text_of

PAGE = "docs/engine.md"


def test_exactly_the_parts_and_options_of_the_bench_are_listed() -> None:
    named = re.findall(r"^\| `(\w+)` \|", text_of(PAGE).partition("## What is measured")[2], re.MULTILINE)
    assert sorted(named[: len(Engine.PARTS)]) == sorted(Engine.PARTS)
    options = re.findall(r"`(--[a-z]+)", text_of(PAGE).partition("## What is measured")[0])
    assert set(options) == {"--only", "--runtime", "--containers", "--placements", "--machines", "--quick", "--json"}


def test_the_limits_are_those_of_the_bench() -> None:
    text = " ".join(text_of(PAGE).split())
    assert ", ".join(f"{name} {limit:g} ms" for name, limit in READY_LIMIT_MS.items()) in text
    assert ", ".join(f"{name} {limit:g} ms" for name, limit in recovery.CRASH_LIMITS_MS.items()) in text
    assert f"| {recovery.LOSS_LIMIT_MS:g} ms |" in text
    assert f"| {master.RATE_LIMIT:g} a second |" in text
    default = EngineOptions()
    assert f"({default.containers})" in text and f"({default.placements} on {default.machines})" in text
    assert f"containers of {CORES:g} cores" in text
    assert PAUSES == {"docker": 5.0} and "five seconds apart" in text
    assert all(f"by `{balancer}`" in text for balancer in BALANCERS)
