"""Figures, as a table and as JSON."""

import json

import pytest

from benchmarks.harness.figures import Figure, measured, median_of

FIGURES = [
    median_of("plans", "REST", [0.003, 0.001, 0.002], limit=1.0),
    Figure("plans", "echo", 0.5, "ms", yardstick=True),
    Figure("fleet", "robots", 12, "robots", limit=10, floor=True, note="in time"),
]


def test_a_median_of_seconds_is_shown_in_milliseconds_with_its_range() -> None:
    assert (FIGURES[0].value, FIGURES[0].least, FIGURES[0].most) == (2.0, 1.0, 3.0)


def test_a_limit_is_an_upper_or_lower_bound() -> None:
    assert [figure.kept for figure in FIGURES] == [False, None, True]


def test_the_json_contains_every_figure() -> None:
    told = json.loads(json.dumps(measured(FIGURES).result))["figures"]
    assert [(figure["name"], figure["value"]) for figure in told] == [("REST", 2.0), ("echo", 0.5), ("robots", 12.0)]


def test_the_table_shows_values_limits_and_notes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    text = measured(FIGURES).text
    assert all(part in text for part in ("2 ms", "1–3", "≤ 1", "≥ 10", "in time"))
