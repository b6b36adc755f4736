"""Part ``lifelong``: memory of a robot that maps the same place for another hour."""

from typing import Any

from benchmarks.harness.figures import Figure
from benchmarks.harness.parts import PartResult
from benchmarks.mapping.lifelong import next_hour
from benchmarks.mapping.parts.part import SlamOptions

GROWTH_LIMIT = 2.0
"""Largest growth in the second hour [MB]."""


def measure(_options: SlamOptions) -> PartResult:
    """Map the office for two hours with mode lifelong."""
    results = next_hour.run()
    return PartResult([figure_of(results)], next_hour.rows(results), results)


def figure_of(results: list[dict[str, Any]]) -> Figure:
    """Return the growth of the memory in the last hour."""
    before, after = results[-2:]
    growth = round(after["memory_mb"] - before["memory_mb"], 2)
    note = f"{after['memory_mb']:.0f} MB; from {before['key_frames']} to {after['key_frames']} key frames"
    return Figure("lifelong", "the next hour in the same place", growth, "MB", limit=GROWTH_LIMIT, note=note)
